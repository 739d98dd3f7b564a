"""Cost of running a campaign of faults in shards, measured on this machine:

    python cost_of_shards.py PALPATE [--shards 1000] [--runs 100000] [--pair 10000]

Compares one run of all cases with the merge of its shards, byte for byte, and measures the cost of
a shard without cases, the cost of the merge, and two shards at once against one after the other.
Times are processor times of the child processes (user and system), which depend least on other
load of the machine. Writes shard-times.json, which schedule.py reads.
"""

import argparse
import filecmp
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


TURNS = 3


def start(command):
    # otherwise the date would make each summary different
    env = {**os.environ, "RAYON_NUM_THREADS": "1", "SOURCE_DATE_EPOCH": "0"}
    return subprocess.Popen([str(part) for part in command], env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def end(process):
    """Waits for a process that must succeed; returns its processor time [s]."""
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{process.args} ended with {process.returncode}")
    return used.ru_utime + used.ru_stime


def run(*command):
    """Runs a command; returns its processor time and wall-clock time [s]."""
    begun = time.monotonic()
    used = end(start(command))
    return used, time.monotonic() - begun


folder = Path.cwd()
parser = argparse.ArgumentParser()
parser.add_argument("palpate", type=Path)
parser.add_argument("--shards", type=int, default=1000)
parser.add_argument("--runs", type=int, default=100_000)
parser.add_argument("--pair", type=int, default=10_000, help="runs of each of two shards at once: about half a minute")
args = parser.parse_args()
palpate = args.palpate.resolve()
found = {"load_average": os.getloadavg(), "shards": args.shards, "runs": args.runs}

with tempfile.TemporaryDirectory() as work:
    os.chdir(work)
    faults = [palpate, "faults", "--runs", args.runs]
    # the same runs in shards and in one process
    times = [run(*faults, "--out", "shards", "--shard", f"{n}/{args.shards}") for n in range(1, args.shards + 1)]
    whole = run(*faults, "--out", "one")
    merge = run(palpate, "merge", "shards", "--out", "merged")
    names = sorted(os.listdir("one"))
    equal, differ, odd = filecmp.cmpfiles("one", "merged", names, shallow=False)
    found |= {
        "bytes_equal": names == sorted(os.listdir("merged")) and not differ and not odd,
        "files": names,
        "one_run_cpu_s": whole[0],
        "shards_cpu_s": sum(used for used, _ in times),
        "merge_cpu_s": merge[0],
        "merge_wall_s": merge[1],
        "bytes_of_a_shard": statistics.mean(f.stat().st_size for f in Path("shards").glob("*/shard.jsonl")),
    }

    # a shard without cases: process, device and patch, checksum of the program, file
    empty = [run(palpate, "faults", "--runs", 100, "--out", "empty", "--shard", "1/1000") for _ in range(50)]
    found["empty_shard_cpu_s"] = statistics.median(used for used, _ in empty)
    found["empty_shard_wall_s"] = statistics.median(wall for _, wall in empty)

    # long shards, two after each other and two at once, in turn: other load affects both alike
    pair = [palpate, "faults", "--runs", 100 * args.pair, "--out"]
    alone, at_once = [], []
    for turn in range(TURNS):
        numbers = [2 * turn + 1, 2 * turn + 2]
        alone += [run(*pair, "alone", "--shard", f"{n}/100")[0] for n in numbers]
        both = [start([*pair, "both", "--shard", f"{n}/100"]) for n in numbers]
        at_once += [end(process) for process in both]
    found["alone_cpu_s"] = alone
    found["at_once_cpu_s"] = at_once
    found["efficiency_on_two_cores"] = sum(alone) / sum(at_once)
    found["load_average_after"] = os.getloadavg()
    os.chdir("/")

overhead_s = found["empty_shard_cpu_s"] + found["merge_cpu_s"] / args.shards
found["overhead_per_shard_s"] = overhead_s
found["overhead_of_a_minute_pct"] = 100 * overhead_s / 60
print(json.dumps(found, indent=1))
(folder / "shard-times.json").write_text(
    json.dumps({**found, "cpu_s": [used for used, _ in times], "runs_of_a_shard": args.runs / args.shards})
)
