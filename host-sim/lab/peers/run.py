"""Runs the engines on the press of press.json and writes peers.csv.

    run.py press.json peers.csv [--only ENGINE] [--model MODEL] [--mesh NAME] [--kpa 3.5] [--from TABLE] [--again | --write]

An engine that is not installed is skipped with a message. Every row that was tried is appended to peers.csv.all next to
the result at once, as one line of JSON. --again measures the times of the kept rows again, so that they can be compared
with a chart that is measured within the same minutes. --from reuses the rows of an earlier table. All options except
--again and --write may be given several times.
"""

import argparse
import csv
import datetime
import importlib
import json
import math
import platform
import sys

import press as P
import search

ENGINES = ["mujoco_flex", "newton_tets", "rapier_fem", "pypbd_xpbd"]


def cells(press, r):
    depths = press.all["held"]["depths_m"]
    speeds = sorted({m["speed_mm_per_s"] for m in press.all["moving"]})
    named = lambda text: str(text).replace(",", ";")
    out = {k: r[k] for k in ("engine", "version", "model", "settings", "mesh", "nodes", "tets", "youngs_modulus_pa", "substeps", "survives_8mm")}
    out["tick_min_us"] = f"{r['tick_min_us']:.2f}"
    out["tick_median_us"] = f"{r['tick_median_us']:.2f}"
    for n, d in enumerate(depths):
        out[f"force_{d * 1e3:g}mm_n"] = f"{r['force_n'][n]:.6f}" if n < len(r["force_n"]) else ""
    out["held_rms_pct"] = f"{r['held_rms_pct']:.3f}"
    for v in speeds:
        error = r["moving_pct"].get(v, r["moving_pct"].get(str(v), math.nan))
        out[f"moving_{v}_mm_per_s_pct"] = f"{error:.3f}" if math.isfinite(error) else ""
    out["force_read"] = r["force_read"]
    return {k: named(v) for k, v in out.items()}


def read(press, path):
    """Reads the rows of a table that was measured with this press, in the form that `search.row` returns."""
    with open(path, encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    if f"# scene = {press.hash}" not in lines:
        sys.exit(f"{path}: is of another press than {press.hash}: measure again")
    rows = []
    for r in csv.DictReader(line for line in lines if not line.startswith("#")):
        numbers = lambda start, end: {k[len(start) : -len(end)]: float(v) for k, v in r.items() if v and k.startswith(start) and k.endswith(end)}
        row = {k: r[k] for k in ("engine", "version", "model", "settings", "mesh", "survives_8mm", "force_read")}
        row |= {k: int(r[k]) for k in ("nodes", "tets", "substeps")}
        row |= {k: float(r[k]) for k in ("youngs_modulus_pa", "tick_min_us", "tick_median_us", "held_rms_pct")}
        row |= {"force_n": list(numbers("force_", "mm_n").values()), "moving_pct": numbers("moving_", "_mm_per_s_pct"), "scene": press.hash}
        row["moving_pct"] = {str(m["speed_mm_per_s"]): math.nan for m in press.all["moving"]} | row["moving_pct"]
        rows.append(row)
    return rows


def write(press, rows, path):
    with open(path, "w", encoding="utf-8", newline="") as file:
        for key, value in {
            "peers": 1,
            "scene": press.hash,
            "machine": press.all["processor"],
            "date": datetime.date.today().isoformat(),
            "palpate": press.all["program"],
            "python": platform.python_version(),
        }.items():
            file.write(f"# {key} = {value}\n")
        table = [cells(press, r) for r in rows]
        writer = csv.DictWriter(file, fieldnames=list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("press")
    parser.add_argument("out")
    parser.add_argument("--only", action="append")
    parser.add_argument("--model", action="append")
    parser.add_argument("--mesh", action="append")
    parser.add_argument("--kpa", action="append", type=float)
    parser.add_argument("--from", action="append", default=[], dest="tables", metavar="TABLE")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--write", action="store_true", help="only write the table of what was measured")
    args = parser.parse_args()
    press = P.Press(args.press)
    log = args.out + ".all"
    old = []
    try:
        old = [json.loads(line) for line in open(log, encoding="utf-8")]
    except FileNotFoundError:
        pass
    old = [r for table in args.tables for r in read(press, table)] + [r for r in old if r["scene"] == press.hash]
    done = {(r["engine"], r["model"], r["settings"], r["mesh"], r["youngs_modulus_pa"]): r for r in old}
    moduli = [k * 1e3 for k in args.kpa] if args.kpa else press.all["youngs_moduli_pa"]
    wanted = search.kept([r for r in done.values() if "held_rms_pct" in r]) if args.again else []
    for name in [] if args.write else args.only or ENGINES:
        try:
            module = importlib.import_module(name)
        except (ImportError, OSError) as why:
            search.say(f"skipped: {name}: {why}: run setup.sh first")
            continue
        for youngs_modulus_pa in moduli:
            for mesh in args.mesh or module.MESHES:
                for model, settings in module.settings(youngs_modulus_pa):
                    if args.model and model not in args.model:
                        continue
                    text = " ".join(f"{k}={v}" for k, v in settings.items()).replace(",", "")
                    key = (module.NAME, model, text, mesh, youngs_modulus_pa)
                    again = args.again and any(key == (r["engine"], r["model"], r["settings"], r["mesh"], r["youngs_modulus_pa"]) for r in wanted)
                    if (args.again and not again) or (not args.again and key in done):
                        continue
                    if again:
                        found = search.timed_again(press, module, settings, press.meshes[mesh], done[key])
                    else:
                        found = search.row(press, module, model, settings, press.meshes[mesh], youngs_modulus_pa)
                    found = found or dict(zip(("engine", "model", "settings", "mesh", "youngs_modulus_pa"), key))
                    found["scene"] = press.hash
                    done[key] = found
                    with open(log, "a", encoding="utf-8") as file:
                        file.write(json.dumps(found) + "\n")
                    if "held_rms_pct" in found:
                        search.say(f"{model:28} {mesh:10} {youngs_modulus_pa:7.0f} Pa {text}: x{found['substeps']} {found['tick_min_us']:.0f} us, held {found['held_rms_pct']:.1f} %, moving {search.moving_rms(found):.1f} %, {found['survives_8mm']}")
                    else:
                        search.say(f"{model:28} {mesh:10} {youngs_modulus_pa:7.0f} Pa {text}: stands no press")
    rows = search.kept([r for r in done.values() if "held_rms_pct" in r])
    if not rows:
        sys.exit("no engine gave a row")
    rows.sort(key=lambda r: (r["engine"], r["model"], r["youngs_modulus_pa"], r["tick_min_us"]))
    write(press, rows, args.out)
    print(f"wrote {args.out}: {len(rows)} rows of {len(done)} tried")


if __name__ == "__main__":
    main()
