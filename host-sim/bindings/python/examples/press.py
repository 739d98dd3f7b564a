"""A press at 10 mm/s, 4 mm deep, in a loop of a thousand ticks per second."""
import time
import palpate

session = palpate.Session("block", device="touch")
session.arm()
start = time.perf_counter()
for tick in range(2500):
    steps = 0 if tick < 700 else min(tick - 700, 2500 - tick)  # above the tissue until the force is ready
    force_n = session.tick(session.site_m + session.axis * (5e-3 - 1e-5 * steps))
    if tick % 100 == 99:
        print(f"{tick + 1} ms {session.depth_m * 1e3:.3f} mm {force_n[2]:.4f} N {session.mode}")
    time.sleep(max(0.0, start + 1e-3 * (tick + 1) - time.perf_counter()))
