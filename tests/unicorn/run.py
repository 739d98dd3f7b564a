"""Runs an image on the model of its chip in lock-step with a test: period in, pins and link out.

    python run.py BOARD IMAGE.elf

BOARD is h743, f446, g474 or pico2. The first line of the input is a scenario, each further line a period of the tick
timer: counts of the three encoders, bytes for the UART in hexadecimal, and `late`, the number of edges of the tick
timer during the tick. Each line is answered with a row of the journal, the first one describing the start-up. After
the end of the input a last line describes the whole run.

A scenario may contain `events`, each of which happens before the period `at`: `loop` replaces the start of the function
whose name contains `symbol` by an endless loop until the watchdog's reset, `hard fault` happens at that function,
`no ticks` stops the tick timer, at `overrun` the UART loses a byte, at `transfer error` the DMA that sends stops, `probe` is a debug probe that wants a full log to wait
for it and never reads, `stop` opens the stop circuit for one period, in which with `supply` the amplifiers' supply is low,
the board is going to `restart` itself and the power fails during operation number `power_fails_in` of the flash, or the
`power` fails at once. `values` are registers that differ after a reset, `cycles_per_reading` is the speed of the cycle
counter, and `count` asks for the instructions between two feedings of the watchdog during start-up.
From period `trace` on, rows contain the executed blocks.
"""

import json
import sys

from unicorn import UcError

from chip import Chip, PowerCut, SystemReset, explain
from rp2350 import Rp2350
from stm32 import CHIPS, Stm32

LOOP = b"\xfe\xe7"  # b .
FIRST_CHANNEL_MODE, BLOCK_IF_FULL = 44, b"\x02"  # in the control block of SEGGER's RTT
LOWERED = ["stop", "supply"]  # events by the number of the input that they lower
RESTART_INSTRUCTIONS = 40_000  # in a period of a board that waits for its watchdog: more than an idle tick takes


def row(chip: Chip, events):
    """Journal row with the events since the last row."""
    line = {
        "pins": chip.pins(),
        "taken": bytes(chip.taken).hex(),
        "sent": bytes(chip.sent).hex(),
        "driven": "driving" in events,
        "resets": chip.resets,
    } | {name: events.count(name) for name in ("fed", "restart", "lost", "flash")}
    if chip.traces:
        line["trace"] = chip.trace[:]
    chip.trace.clear()
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


def start(chip: Chip):
    """Runs the start-up, anew after each cut of the power and each reset."""
    while True:
        try:
            return chip.run_until_sleep()
        except PowerCut:
            chip.power_on()
        except SystemReset:
            chip.reset(by_watchdog=False)


def tell(what):
    print(json.dumps(what), flush=True)


def main():
    board, image = sys.argv[1:]
    scenario = json.loads(sys.stdin.readline())
    values = {int(at, 0): value for at, value in scenario.get("values", {}).items()}
    chip = Stm32(board, image, values) if board in CHIPS else Rp2350(image)
    chip.CYCLES_PER_READING = scenario.get("cycles_per_reading", chip.CYCLES_PER_READING)
    events, planted, hangs = {event["at"]: event for event in scenario.get("events", [])}, None, 0
    last = None
    try:
        counting = scenario.get("count") and chip.count_instructions()
        start(chip)
        if counting:
            chip.uc.hook_del(counting)
            chip.uc.ctl_flush_tb()
        tell(row(chip, chip.journal))
        for number, line in enumerate(sys.stdin):
            period = json.loads(line)
            if number == scenario.get("trace"):
                chip.trace_blocks()
            chip.encoders = period["counts"]
            chip.to_board += bytes.fromhex(period["bytes"])
            event = events.get(number, {})
            happens = event.get("how")
            if happens == "loop":
                at = place_of(chip, event["symbol"])
                planted = (at, bytes(chip.uc.mem_read(at, 2)))
                write(chip, at, LOOP)
            elif happens == "hard fault":
                chip.plant_hard_fault(place_of(chip, event["symbol"]), event["cfsr"], event["bfar"])
            elif happens == "overrun":
                chip.overrun = True
            elif happens == "transfer error":
                chip.fail_transfer()
            elif happens == "probe":
                write(chip, chip.symbols["_SEGGER_RTT"] + FIRST_CHANNEL_MODE, BLOCK_IF_FULL)
            elif happens == "no ticks":
                chip.stop_ticks()
            elif happens == "restart":
                chip.power_fails_in = event.get("power_fails_in", 0)
            elif happens == "power":
                chip.power_on()
                start(chip)
            for input_, how in enumerate(LOWERED):
                if happens == how or last == how:
                    chip.lower(input_, happens == how)
            last = happens
            if happens in ("loop", "hard fault"):
                hangs = chip.cycles_per_period()
            elif happens == "restart":
                hangs = RESTART_INSTRUCTIONS
            before = chip.resets
            chip.period(hangs, period["late"])
            answer = row(chip, chip.journal)
            if chip.resets > before:
                if planted:
                    write(chip, *planted)
                planted, hangs = None, 0
                start(chip)
            tell(answer)
    except UcError as error:
        sys.exit(explain(chip, error))
    tell(
        {
            "period_steps": chip.period_steps(),
            "watchdog_ms": min(chip.watchdogs().values(), default=0),
            "longest_unfed": chip.longest_unfed,
            "registers": {hex(at): value for at, value in chip.registers.items()},
        }
    )


if __name__ == "__main__":
    main()
