"""Simulates a campaign on many cores from the times of shards on this machine:

    python schedule.py shard-times.json [--runs 1e10] [--cores 1000]

Each core takes the next shard when it is free; the scheduler needs a fixed time for each start; a
core fails at random, and its shard runs again. The times of runs are drawn from the distribution
that cost_of_shards.py measured, the speeds of nodes of 32 cores from an assumed one. Prints the use
of the core-hours. The results were not compared with a real cluster.
"""

import argparse
import heapq
import json
import math
import random
import statistics

parser = argparse.ArgumentParser()
parser.add_argument("times")
parser.add_argument("--runs", type=float, default=1e10)
parser.add_argument("--cores", type=int, default=1000)
parser.add_argument("--spread", type=float, default=0.03, help="standard deviation of the speed of nodes (1), assumed")
parser.add_argument("--start-s", type=float, default=0.01, help="time between two starts by the scheduler, assumed")
parser.add_argument("--fail-h", type=float, default=10_000, help="hours from failure to failure of a core, assumed")
args = parser.parse_args()

with open(args.times) as file:
    measured = json.load(file)
of_a_shard = measured["runs_of_a_shard"]
start_s = measured["empty_shard_cpu_s"]
merge_s = measured["merge_cpu_s"] / measured["shards"]
run_s = (statistics.mean(measured["cpu_s"]) - start_s) / of_a_shard
# runs are independent, so the relative scatter decreases with the square root of their number
scatter = statistics.stdev(measured["cpu_s"]) / (run_s * of_a_shard)
NODE = 32

print(f"measured: {run_s * 1e3:.3f} ms a run, start {start_s:.3f} s, merge {merge_s * 1e3:.2f} ms a shard,", end=" ")
print(f"scatter of shards of {of_a_shard:.0f} runs {100 * scatter:.1f} %")
print(f"{args.runs:.0e} runs are {args.runs * run_s / 3600:.0f} core-hours, {args.runs * run_s / 3600 / args.cores:.2f} h on {args.cores} cores")
HEADER = ("shards", "s each", "hours", "efficiency", "work", "start", "waiting", "idle at end", "run again", "merge s")
print("share of the core-hours [%]: efficiency is the work of nodes of even speed; waiting: for a start by the scheduler")
print(" ".join(f"{name:>11}" for name in HEADER))
for shards in (1_000, 5_000, 10_000, 36_000, 100_000, 1_000_000):
    random.seed(1)
    runs = args.runs / shards
    drawn = [random.gauss(1, args.spread) for _ in range(math.ceil(args.cores / NODE))]
    speed = [each / statistics.mean(drawn) for each in drawn]
    free = [(0.0, core) for core in range(args.cores)]
    left, next_start = shards, 0.0
    work = begin = wait = lost = 0.0
    ends = [0.0] * args.cores
    rate = 1 / (args.fail_h * 3600)
    while left:
        at, core = heapq.heappop(free)
        started = max(at, next_start)
        next_start = started + args.start_s
        wait += started - at
        share = random.gauss(1, scatter * math.sqrt(of_a_shard / runs))
        takes = start_s + runs * run_s * max(share, 0.1) / speed[core // NODE]
        broken = random.expovariate(rate)
        if broken < takes:
            lost += broken
            takes = broken
        else:
            begin += start_s
            work += takes - start_s
            left -= 1
        ends[core] = started + takes
        heapq.heappush(free, (ends[core], core))
    span = max(ends)
    core_s = span * args.cores
    idle = core_s - work - begin - wait - lost
    ideal = args.runs * run_s
    parts = [100 * part / core_s for part in (ideal, work, begin, wait, idle, lost)]
    cells = [f"{shards}", f"{runs * run_s:.0f}", f"{span / 3600:.2f}", *(f"{part:.2f}" for part in parts), f"{merge_s * shards:.1f}"]
    print(" ".join(f"{cell:>11}" for cell in cells))
