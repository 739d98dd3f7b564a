"""Checks the static reference of the chart with CalculiX, a solver that is independent of this project.

    calculix.py press.json FOLDER

Solves the decks that the example `calculix` of palpate-lab writes (in host-sim/lab: cargo run --release --example
calculix -- write FOLDER) with ccx, and prints its forces next to the reference against which all engines are judged.
Ends with a message if ccx is missing.
"""

import json
import pathlib
import shutil
import subprocess
import sys

# modulus [kPa] and depths [mm] of the decks; they model a quarter of the block, so the force is multiplied by four, see deck.rs
MODULUS_KPA, DEPTHS_MM, COPIES = 3.5, (1.0, 2.0, 4.0), 4.0
DECKS = {"press": "our law", "neo-hooke": "its own neo-Hookean law"}


def forces_mn(path):
    """Total force along the press at the end of each step [mN]."""
    lines = iter(path.read_text(encoding="utf-8").splitlines())
    found = []
    for line in lines:
        if line.strip().startswith("total force"):
            numbers = next(text for text in lines if text.strip())
            found.append(-float(numbers.split()[2]) * COPIES)
    return found


def main():
    if not shutil.which("ccx"):
        sys.exit("skipped: CalculiX (ccx) is missing: install it (Debian: apt-get install calculix-ccx)")
    press = json.load(open(sys.argv[1], encoding="utf-8"))
    folder = pathlib.Path(sys.argv[2])
    truth = dict(zip((round(d * 1e3, 3) for d in press["held"]["depths_m"]), press["held"]["force_over_e_m2"]))
    print(f"{'law':26} {'depth mm':>8} {'CalculiX N':>11} {'reference N':>11} {'apart %':>8}")
    for deck, law in DECKS.items():
        if not (folder / f"{deck}.inp").exists():
            sys.exit(f"{folder / deck}.inp is missing: write it with the example calculix of palpate-lab")
        with open(folder / f"{deck}.log", "w", encoding="utf-8") as log:
            subprocess.run(["ccx", "-i", deck], cwd=folder, stdout=log, stderr=log, check=False)
        found = forces_mn(folder / f"{deck}.dat")
        if len(found) != len(DEPTHS_MM):
            sys.exit(f"{deck}: CalculiX finished {len(found)} of {len(DEPTHS_MM)} steps: see {folder / deck}.log")
        for depth, force in zip(DEPTHS_MM, found):
            reference = truth[depth] * MODULUS_KPA * 1e3
            print(f"{law:26} {depth:8} {force * 1e-3:11.5f} {reference:11.5f} {(force * 1e-3 / reference - 1) * 100:+8.2f}")


if __name__ == "__main__":
    main()
