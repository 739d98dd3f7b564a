"""Runs an image through a scenario on the chip of `chip.py`, and writes a journal of its pins and its link.

    python run.py IMAGE.elf SCENARIO.json JOURNAL.json

A scenario has one row per period of the tick timer: counts of the three encoders, and the bytes for the UART
in hexadecimal. Before the period `at`, `hang` replaces the start of the function whose name contains `symbol`
by an endless loop, or stops the tick timer; the watchdog's reset removes the loop. The first row of the
journal describes the start-up.
"""

import json
import struct
import sys

from unicorn import UcError

from chip import BASE, CR1, Chip, explain

LOOP = b"\xfe\xe7"  # b .


def row(chip, events):
    """Journal row with the events since the last row."""
    line = {
        "pins": chip.pins(),
        "taken": bytes(chip.taken).hex(),
        "sent": bytes(chip.sent).hex(),
        "fed": events.count("fed"),
        "driven": "driving" in events,
        "resets": chip.resets,
    }
    chip.taken.clear()
    chip.sent.clear()
    events.clear()
    return line


def main():
    image, scenario, journal = sys.argv[1:]
    with open(scenario, encoding="utf-8") as file:
        scenario = json.load(file)
    chip = Chip(image)
    hang, planted = scenario.get("hang"), None
    rows = []
    try:
        chip.run_until_sleep()
        rows.append(row(chip, chip.journal))
        for number, period in enumerate(scenario["periods"]):
            chip.encoders = period["counts"]
            chip.to_board += bytes.fromhex(period["bytes"])
            if hang and number == hang["at"]:
                if hang["how"] == "loop":
                    found = [(name, at) for name, at in chip.symbols.items() if hang["symbol"] in name and "Thunk" not in name]
                    if len(found) != 1:
                        sys.exit(f"{hang['symbol']} is {len(found)} functions of the image")
                    planted = (found[0][1], bytes(chip.uc.mem_read(found[0][1], 2)))
                    chip.uc.mem_write(found[0][1], LOOP)
                    chip.uc.ctl_remove_cache(found[0][1], found[0][1] + 2)
                else:
                    chip.registers[BASE["TIM7"] + CR1] = 0
            before = chip.resets
            chip.period(hangs=planted is not None)
            rows.append(row(chip, chip.journal))
            if chip.resets > before:
                if planted:
                    chip.uc.mem_write(*planted)
                    chip.uc.ctl_remove_cache(planted[0], planted[0] + 2)
                    planted = None
                chip.run_until_sleep()
    except UcError as error:
        sys.exit(explain(chip, error))
    with open(journal, "w", encoding="utf-8") as file:
        json.dump({"period_steps": chip.period_steps(), "watchdog_ms": chip.watchdog_periods(), "rows": rows}, file)


if __name__ == "__main__":
    main()
