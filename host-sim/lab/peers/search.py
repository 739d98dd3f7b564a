"""Search for the best settings: every setting of an engine's list is run on every mesh, and the best rows are kept.

For each setting the smallest number of substeps with which the engine survives the deepest press is found by doubling
and bisection, as for our own methods. If there is none, the smallest number that stays finite is used, and the row says
how the engine fails. Numbers of substeps whose tick takes longer than MOST_TICK_S are not tried. Of the rows of one
engine and model at one stiffness those are kept that no other row beats in cost, held error and moving error together.
"""

import math
import sys
import time

import press as P

MOST_TICK_S = 0.02


class TooSlow(Exception):
    pass


def attempt(press, build, substeps):
    """Runs the deepest press with this number of substeps; returns None if the engine survives, else the reason why not."""
    engine = build(substeps)
    began, ticks = time.thread_time(), 20
    own = engine.cpu_s()
    try:
        for _ in range(ticks):
            P.go(engine, -press.all["survival"]["clear_m"])
    except P.Diverged as why:
        return str(why)
    took = engine.cpu_s() - own if own is not None else time.thread_time() - began
    if took / ticks > MOST_TICK_S:
        raise TooSlow
    return P.survive(press, build(substeps))


def least_substeps(press, build, most):
    """Returns (substeps, None or the way in which the engine fails with them); None if it always diverges."""
    tried, substeps = [], 1
    try:
        while substeps <= most:
            why = attempt(press, build, substeps)
            tried.append((substeps, why))
            if why is None:
                break
            substeps *= 2
    except TooSlow:
        pass
    if not tried or tried[-1][1] is not None:
        finite = [t for t in tried if not t[1].startswith("diverges")]
        return finite[0] if finite else None
    best = tried[-1][0]
    low = tried[-2][0] if len(tried) > 1 else best - 1
    while best - low > 1:
        middle = (low + best) // 2
        if attempt(press, build, middle) is None:
            best = middle
        else:
            low = middle
    return best, None


def row(press, module, model, settings, mesh, youngs_modulus_pa):
    """Measures one row of peers.csv; None if the engine cannot run the press."""
    build = lambda substeps: module.Engine(press, mesh, youngs_modulus_pa, substeps, settings)
    most = press.all["survival"]["most_substeps"] if settings.get("takes_substeps", True) else 1
    found = least_substeps(press, build, most)
    if found is None:
        return None
    substeps, why = found
    forces = P.held_forces(press, build(substeps))
    if not forces:
        return None
    moving = {}
    for ramp in press.all["moving"]:
        if ramp["youngs_modulus_pa"] == youngs_modulus_pa:
            try:
                moving[ramp["speed_mm_per_s"]] = P.moving_error_pct(ramp, build(substeps))
            except P.Diverged:
                moving[ramp["speed_mm_per_s"]] = math.nan
    try:
        took = P.tick_time(press, build(substeps))
    except P.Diverged:
        return None
    return {
        "engine": module.NAME,
        "version": module.VERSION,
        "model": model,
        "settings": " ".join(f"{k}={v}" for k, v in settings.items()).replace(",", ""),
        "mesh": mesh.name,
        "nodes": len(mesh.nodes_m),
        "tets": len(mesh.tets),
        "youngs_modulus_pa": youngs_modulus_pa,
        "substeps": substeps,
        "survives_8mm": why or "yes",
        "tick_min_us": took.min_us,
        "tick_median_us": took.median_us,
        "force_n": forces,
        "held_rms_pct": P.rms(P.held_errors_pct(press, forces, youngs_modulus_pa)),
        "moving_pct": moving,
        "force_read": module.FORCE,
    }


def timed_again(press, module, settings, mesh, old):
    """Returns the row with its time measured again; forces do not depend on the load of the machine."""
    took = P.tick_time(press, module.Engine(press, mesh, old["youngs_modulus_pa"], old["substeps"], settings))
    return {**old, "tick_min_us": took.min_us, "tick_median_us": took.median_us}


def moving_rms(row):
    errors = list(row["moving_pct"].values())
    return P.rms(errors) if errors else math.nan


def kept(rows):
    """Rows that no other row of the same engine, model and stiffness beats in cost and both errors."""
    def three(r):
        moving = moving_rms(r)
        return (r["tick_min_us"], r["held_rms_pct"], moving if math.isfinite(moving) else math.inf)

    def group(r):
        return (r["engine"], r["model"], r["youngs_modulus_pa"])

    def beaten(r):
        own = three(r)
        rivals = (three(o) for o in rows if o is not r and group(o) == group(r))
        return any(all(a <= b for a, b in zip(o, own)) and o != own for o in rivals)

    return [r for r in rows if not beaten(r)]


def say(*words):
    print(*words, file=sys.stderr, flush=True)
