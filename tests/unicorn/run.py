"""Runs an image through a scenario on the model of its chip, and writes a journal of its pins and its link.

    python run.py BOARD IMAGE.elf SCENARIO.json JOURNAL.json

BOARD is h743, f446, g474 or pico2. A scenario has one row per period of the tick timer: counts of the three
encoders, and the bytes for the UART in hexadecimal. Before the period `at`, the event `how` happens: `loop` replaces
the start of the function whose name contains `symbol` by an endless loop until the watchdog's reset, `hard fault`
happens at that function, `no ticks` stops the tick timer, `stop` opens the stop circuit for one period. `values` are
registers that differ after a reset, `cycles_per_reading` is the speed of the cycle counter, and `count` asks for the
instructions between two feedings of the watchdog during start-up. The first row of the journal describes the start-up.
"""

import json
import sys

from unicorn import UcError

from chip import Chip, explain
from rp2350 import Rp2350
from stm32 import CHIPS, Stm32

LOOP = b"\xfe\xe7"  # b .


def row(chip: Chip, events):
    """Journal row with the events since the last row."""
    line = {
        "pins": chip.pins(),
        "taken": bytes(chip.taken).hex(),
        "sent": bytes(chip.sent).hex(),
        "driven": "driving" in events,
        "resets": chip.resets,
    } | {name: events.count(name) for name in ("fed", "restart", "lost")}
    chip.taken.clear()
    chip.sent.clear()
    events.clear()
    return line


def place_of(chip: Chip, symbol):
    found = [at for name, at in chip.symbols.items() if symbol in name and "Thunk" not in name]
    if len(found) != 1:
        sys.exit(f"{symbol} is {len(found)} functions of the image")
    return found[0]


def write(chip: Chip, at, bytes_):
    chip.uc.mem_write(at, bytes_)
    chip.uc.ctl_remove_cache(at, at + len(bytes_))


def main():
    board, image, scenario, journal = sys.argv[1:]
    with open(scenario, encoding="utf-8") as file:
        scenario = json.load(file)
    values = {int(at, 0): value for at, value in scenario.get("values", {}).items()}
    chip = Stm32(board, image, values) if board in CHIPS else Rp2350(image)
    chip.CYCLES_PER_READING = scenario.get("cycles_per_reading", chip.CYCLES_PER_READING)
    event, planted, hangs = scenario.get("event") or {"at": None}, None, False
    rows = []
    try:
        counting = scenario.get("count") and chip.count_instructions()
        chip.run_until_sleep()
        if counting:
            chip.uc.hook_del(counting)
            chip.uc.ctl_flush_tb()
        rows.append(row(chip, chip.journal))
        for number, period in enumerate(scenario["periods"]):
            chip.encoders = period["counts"]
            chip.to_board += bytes.fromhex(period["bytes"])
            happens = event["how"] if number == event["at"] else None
            if happens == "loop":
                at = place_of(chip, event["symbol"])
                planted = (at, bytes(chip.uc.mem_read(at, 2)))
                write(chip, at, LOOP)
            elif happens == "hard fault":
                chip.plant_hard_fault(place_of(chip, event["symbol"]), event["cfsr"], event["bfar"])
            elif happens == "no ticks":
                chip.stop_ticks()
            if event.get("how") == "stop":
                chip.open_stop_circuit(happens == "stop")
            hangs |= happens in ("loop", "hard fault")
            before = chip.resets
            chip.period(hangs)
            rows.append(row(chip, chip.journal))
            if chip.resets > before:
                if planted:
                    write(chip, *planted)
                planted, hangs = None, False
                chip.run_until_sleep()
    except UcError as error:
        sys.exit(explain(chip, error))
    told = {
        "period_steps": chip.period_steps(),
        "watchdog_ms": min(chip.watchdogs().values(), default=0),
        "longest_unfed": chip.longest_unfed,
        "registers": {hex(at): value for at, value in chip.registers.items()},
        "rows": rows,
    }
    with open(journal, "w", encoding="utf-8") as file:
        json.dump(told, file)


if __name__ == "__main__":
    main()
