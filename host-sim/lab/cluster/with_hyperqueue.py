"""Runs a palpate campaign under HyperQueue on this machine, one shard per task:

    pip install hyperqueue==0.27.0
    python with_hyperqueue.py 1000 palpate-lab faults --runs 100000000 --out faults

The arguments are the number of shards, then the command with all of its options except --shard. A
shard whose file exists is not run again, so the same command line after a failure runs the shards
that are missing.
"""

import os
import sys
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

shards, command = int(sys.argv[1]), sys.argv[2:]
out = Path(command[command.index("--out") + 1])
folder = Path.cwd()
job = Job(folder)
for number in range(1, shards + 1):
    if not (out / f"shard-{number}-of-{shards}" / "shard.jsonl").exists():
        # one core per task: HyperQueue gives each task one by default
        job.program(
            [*command, "--shard", f"{number}/{shards}"],
            env={"RAYON_NUM_THREADS": "1"},
            stdout=str(folder / "shards.out" / f"{number}.out"),
            stderr=str(folder / "shards.out" / f"{number}.err"),
        )
if not job.tasks:
    sys.exit(f"all {shards} shards are in {out}: merge them")
with LocalCluster() as cluster:
    cluster.start_worker(WorkerConfig(cores=os.cpu_count()))
    client = cluster.client()
    # the merge names a shard that failed, and says how to run it again
    client.wait_for_jobs([client.submit(job)], raise_on_error=False)
