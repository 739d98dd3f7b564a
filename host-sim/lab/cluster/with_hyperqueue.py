"""A palpate campaign under HyperQueue on this machine, a shard per task:

    pip install hyperqueue==0.27.0
    python with_hyperqueue.py 1000 palpate-full faults --runs 100000000 --out faults

First the number of shards, then the command with all of its options but --shard. A shard whose
file is there already is not run again, so the same line after a failure runs what is missing.
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
    # a shard that failed is named by the merge, with how to run it again
    client.wait_for_jobs([client.submit(job)], raise_on_error=False)
