"""A Cortex-M core with an image in its flash: memories, prioritised interrupts, a hard fault, a watchdog, a UART.

A chip's file adds its registers (`stm32.py`, `rp2350.py`), as complete as the image needs. Unicorn executes the
core's instructions. The model's time does not advance while they run; whenever the core sleeps, it advances by one
period of the tick timer. In a loop that never sleeps, a period lasts as many instructions as the core has cycles. The
model therefore does not show how long a tick takes; the image's cycle counter advances at each of its readings.
"""

import struct

from elftools.elf.elffile import ELFFile
from unicorn import (
    UC_ARCH_ARM,
    UC_ERR_READ_PROT,
    UC_HOOK_BLOCK,
    UC_HOOK_CODE,
    UC_MODE_MCLASS,
    UC_MODE_THUMB,
    UC_PROT_ALL,
    UC_PROT_WRITE,
    Uc,
    UcError,
)
from unicorn.arm_const import (
    UC_ARM_REG_FPSCR,
    UC_ARM_REG_LR,
    UC_ARM_REG_PC,
    UC_ARM_REG_PRIMASK,
    UC_ARM_REG_R0,
    UC_ARM_REG_R1,
    UC_ARM_REG_R2,
    UC_ARM_REG_R3,
    UC_ARM_REG_R12,
    UC_ARM_REG_S0,
    UC_ARM_REG_SP,
    UC_ARM_REG_XPSR,
)

SCS, CYCLE_COUNT = 0xE000_E000, 0xE000_1004
CFSR, BFAR = SCS + 0xD28, SCS + 0xD38
BYTES_IN_A_TICK = 92  # at 921 600 baud
LATE_INSTRUCTIONS = 20_000  # after which a late tick is interrupted by the next period; a press takes three times as many
RETURN = 0x1FFF_0000  # stands for an exception return; the page is executable
HARD_FAULT, SYSTICK = 3 - 16, 15 - 16  # vectors, counted from the first interrupt
FRAME = [UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_XPSR]


class PowerCut(Exception):
    """The power fails while the flash is erased or written."""


class SystemReset(Exception):
    """The image resets the chip."""


class Chip:
    """A chip with an image in its flash."""

    MEMORY = []  # (start, size)
    REGISTERS = [(0x4000_0000, 0x2000_0000), (0xE000_0000, 0x10_0000)]  # (start, size)
    CPU = None
    FIFO_BYTES = 16
    UNREADABLE_IF_TORN = False  # whether reading a half-written word of the flash is a fault
    CYCLES_PER_READING = 64  # of the cycle counter, which must move, or delays would be endless

    def __init__(self, elf):
        self.trace = []
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(self.CPU)
        for start, size in self.MEMORY:
            self.uc.mem_map(start, size, UC_PROT_ALL)
            if 0 < start < 0x2000_0000:
                self.uc.mem_write(start, b"\xff" * size)
        with open(elf, "rb") as file:
            image = ELFFile(file)
            for segment in image.iter_segments():
                if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]:
                    self.uc.mem_write(segment["p_paddr"], segment.data())
            table = image.get_section_by_name(".symtab")
            self.symbols = {symbol.name: symbol["st_value"] & ~1 for symbol in table.iter_symbols() if symbol["st_value"]}
            self.vectors = image.get_section_by_name(".vector_table")["sh_addr"]
        for start, size in self.REGISTERS:
            self.uc.mmio_map(start, size, self._read, start, self._write, start)
        self.uc.mem_map(RETURN, 0x1000, UC_PROT_ALL)
        self.uc.mem_write(RETURN, b"\x00\xbf" * 0x800)
        self.uc.hook_add(UC_HOOK_CODE, lambda *_: self.uc.emu_stop(), begin=RETURN, end=RETURN + 0xFFF)
        self.encoders = [0, 0, 0]
        self.to_board, self.fifo, self.taken, self.sent = bytearray(), bytearray(), bytearray(), bytearray()
        self.send_room = self.FIFO_BYTES
        self.periods = 0
        self.journal = []
        self.resets = 0
        self.reset(by_watchdog=False)

    # what a chip's file adds

    def reset_values(self, by_watchdog):
        """Registers after a reset, by address."""
        raise NotImplementedError

    def word(self, address, kept):
        """Value that a register shows, `kept` being the one written last."""
        return kept

    def stores(self, address, value):
        """Whether the register keeps the value; carries out what else the write does."""
        return True

    def driving(self):
        """Whether a force could act: the main output or the enable line is on."""
        raise NotImplementedError

    def pins(self):
        """States of the enable line, the main output, the compare registers and the direction pins."""
        raise NotImplementedError

    def watchdogs(self):
        """Name and time limit of each watchdog that runs, in periods of the tick timer."""
        raise NotImplementedError

    def raises(self):
        """Interrupts that begin with a period of the tick timer."""
        raise NotImplementedError

    def uart_irqs(self):
        """Interrupts that the UART asks for."""
        raise NotImplementedError

    def move_bytes(self):
        """Bytes that a DMA moves within a period between memory and UART."""

    # flash, which the image erases and writes

    def erase(self, first, size):
        """Erases a sector, half of it if the power fails meanwhile."""
        fails = self._operation()
        self.uc.mem_protect(first & ~0xFFF, max(size, 0x1000), UC_PROT_ALL)
        self.uc.mem_write(first, b"\xff" * (size // 2 if fails else size))
        if fails:
            raise PowerCut

    def write(self, first, data):
        """Writes erased bytes, some of their bits if the power fails meanwhile."""
        assert set(self.uc.mem_read(first, len(data))) == {0xFF}, f"{first:#x} is not erased"
        fails = self._operation()
        self.uc.mem_write(first, bytes(byte | 0x5A for byte in data) if fails else bytes(data))
        if fails:
            if self.UNREADABLE_IF_TORN:
                self.uc.mem_protect(first & ~0xFFF, 0x1000, UC_PROT_WRITE)
            raise PowerCut

    def _operation(self):
        self.journal.append("flash")
        assert not self.driving() and not self.watchdogs(), "the flash is written while a force can act"
        self.power_fails_in -= 1
        return self.power_fails_in == 0

    def power_on(self):
        """Starts anew: RAM has any content, the flash has its own."""
        for start, size in self.MEMORY:
            if start >= 0x2000_0000:
                self.uc.mem_write(start, b"\xc5" * size)
        self.reset(by_watchdog=False)

    # registers

    def reset(self, by_watchdog):
        """Sets every register to its reset value; RAM keeps its content."""
        self.registers = self.reset_values(by_watchdog)
        self.enabled, self.pending, self.active = {HARD_FAULT, SYSTICK}, set(), []
        self.fed = {}
        self.overrun = False
        self.fifo.clear()
        self.send_room = self.FIFO_BYTES
        self.resets += 1
        stack, entry = struct.unpack("<II", self.uc.mem_read(self.vectors, 8))
        self.uc.reg_write(UC_ARM_REG_PRIMASK, 0)
        self.uc.reg_write(UC_ARM_REG_SP, stack)
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24)
        self.pc = entry & ~1

    def at(self, address):
        return self.registers.get(address, 0)

    def _read(self, _uc, offset, size, base):
        address = base + offset
        place = self.place(address & ~3)
        if place == CYCLE_COUNT:
            self.cycles = max(self.cycles + self.CYCLES_PER_READING, self.periods * self.cycles_per_period())
            return self.cycles & 0xFFFF_FFFF
        word = self.word(place, self.at(place)) >> (8 * (address & 3))
        return word & ((1 << (8 * size)) - 1)

    def _write(self, _uc, offset, size, value, base):
        address = base + offset
        word, shift = address & ~3, 8 * (address & 3)
        place = self.place(word)
        value = self.merged(word, size, shift, value)
        bits = lambda first: {32 * (place - SCS - first) // 4 + bit for bit in range(32) if value >> bit & 1}
        scs = place - SCS
        if 0x100 <= scs < 0x120:
            self.enabled |= bits(0x100)
        elif 0x180 <= scs < 0x1A0:
            self.enabled -= bits(0x180)
        elif 0x200 <= scs < 0x220:
            self.pending |= bits(0x200)
            self._stop()
        elif 0x280 <= scs < 0x2A0:
            self.pending -= bits(0x280)
        elif scs == 0xD0C and value & 4:
            raise SystemReset
        elif scs == 0xF00:
            self.pending.add(value & 0x1FF)
            self._stop()
        elif self.stores(place, value):
            self.registers[place] = value
        if self.driving():
            self.journal.append("driving")

    def place(self, address):
        """Address under which a register is kept."""
        return address

    def merged(self, word, size, shift, value):
        """The whole word after a write of some of its bytes."""
        mask = ((1 << (8 * size)) - 1) << shift
        return self.at(word) & ~mask | value << shift & mask

    def take_byte(self):
        """The oldest byte from the host, as the image reads it."""
        self.taken.append(self.fifo[0])
        return self.fifo.pop(0)

    def send_byte(self, byte):
        """The image writes a byte for the host."""
        assert self.send_room > 0, "a byte is written to a full queue"
        self.send_room -= 1
        self.sent.append(byte)

    def send_from(self, address, count):
        """A DMA sends bytes of the memory; returns how many the line takes within the period."""
        count = min(count, self.line_bytes)
        self.line_bytes -= count
        self.sent += self.uc.mem_read(address, count)
        return count

    def feed(self, watchdog, starts=True):
        """The image feeds a watchdog, which may not have been started yet."""
        if starts:
            self.fed[watchdog] = self.periods
        self.journal.append("fed")
        self.longest_unfed, self.unfed = max(self.longest_unfed, self.unfed or 0), 0

    def _stop(self):
        if self._next_irq() is not None:
            self.stored = True
            self.uc.emu_stop()

    # interrupts

    def _priority(self, irq):
        if irq < 0:
            return -1 if irq == HARD_FAULT else self.at(SCS + 0xD20) >> 24
        return self.at(SCS + 0x400 + (irq & ~3)) >> (8 * (irq & 3)) & 0xFF

    def _next_irq(self):
        masked = self.uc.reg_read(UC_ARM_REG_PRIMASK) & 1
        waiting = [(self._priority(irq), irq) for irq in self.pending & self.enabled if not masked or irq == HARD_FAULT]
        running = min((self._priority(irq) for irq in self.active), default=256)
        return min(waiting)[1] if waiting and min(waiting)[0] < running else None

    def _enter(self, irq):
        """Enters an interrupt: stacks core and floating-point registers, as without lazy stacking."""
        self.pending.discard(irq)
        self.active.append(irq)
        self.trace += [0, 0]
        self.uc.reg_write(UC_ARM_REG_PC, self.pc)
        words = [self.uc.reg_read(register) for register in FRAME]
        words[6] = self.pc
        old = self.uc.reg_read(UC_ARM_REG_SP)
        stack = (old - 104) & ~7
        words[7] = words[7] & ~(1 << 9) | (old - 104 & 4) << 7
        words += [self.uc.reg_read(UC_ARM_REG_S0 + n) for n in range(16)] + [self.uc.reg_read(UC_ARM_REG_FPSCR), 0]
        self.uc.mem_write(stack, struct.pack("<26I", *words))
        self.uc.reg_write(UC_ARM_REG_SP, stack)
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24)
        self.uc.reg_write(UC_ARM_REG_LR, RETURN | 1)
        self.pc = struct.unpack("<I", self.uc.mem_read(self.vectors + 4 * (16 + irq), 4))[0] & ~1

    def _leave(self):
        self.active.pop()
        stack = self.uc.reg_read(UC_ARM_REG_SP)
        words = struct.unpack("<26I", self.uc.mem_read(stack, 104))
        for register, word in zip(FRAME[:6], words):
            self.uc.reg_write(register, word)
        for n in range(16):
            self.uc.reg_write(UC_ARM_REG_S0 + n, words[8 + n])
        self.uc.reg_write(UC_ARM_REG_FPSCR, words[24])
        self.uc.reg_write(UC_ARM_REG_SP, stack + 104 + (4 if words[7] >> 9 & 1 else 0))
        self.uc.reg_write(UC_ARM_REG_XPSR, words[7] & ~(1 << 9))
        self.pc = words[6]

    def plant_hard_fault(self, address, cfsr, bfar):
        """The next time that the core reaches an address, a hard fault happens there."""

        def hit(*_):
            self.uc.hook_del(hook)
            self.registers[CFSR], self.registers[BFAR] = cfsr, bfar
            self.pending.add(HARD_FAULT)
            self.uc.emu_stop()

        hook = self.uc.hook_add(UC_HOOK_CODE, hit, begin=address, end=address)
        self.uc.ctl_remove_cache(address, address + 2)

    def count_instructions(self):
        """Counts the instructions between two feedings of a watchdog from now on."""

        lengths = {}  # instructions of a block, by its place and its bytes

        def length(block):
            halves = struct.unpack(f"<{block[1] // 2}H", self.uc.mem_read(*block))
            count = 0
            while halves:
                count, halves = count + 1, halves[2 if halves[0] >> 11 >= 0x1D else 1 :]
            return count

        def count(_uc, address, size, _):
            if self.unfed is not None:
                block = (address, size)
                if block not in lengths:
                    lengths[block] = length(block)
                self.unfed += lengths[block]

        self.uc.ctl_flush_tb()
        return self.uc.hook_add(UC_HOOK_BLOCK, count)

    def trace_blocks(self):
        """Keeps the executed blocks from now on: their addresses and sizes, and zeros for the entry of an interrupt."""
        self.traces = True
        self.uc.ctl_flush_tb()
        self.uc.hook_add(UC_HOOK_BLOCK, lambda _uc, address, size, _: self.trace.extend((address, size)))

    # time

    def run_until_sleep(self, most=0):
        """Runs until the core sleeps or, if `most` is not 0, for at most that many instructions; returns whether it sleeps."""
        while True:
            irq = self._next_irq()
            if irq is not None:
                self._enter(irq)
            try:
                self.uc.emu_start(self.pc | 1, 0xFFFF_FFFE, count=most)
            except UcError as error:
                if error.errno != UC_ERR_READ_PROT:
                    raise
                self.pending.add(HARD_FAULT)
            self.pc = self.uc.reg_read(UC_ARM_REG_PC) & ~1
            if self.stored:  # stopped after the store that set an interrupt pending: skip that store
                self.stored = False
                first = struct.unpack("<H", self.uc.mem_read(self.pc, 2))[0]
                self.pc += 4 if first >> 11 >= 0x1D else 2
            if RETURN <= self.pc < RETURN + 0x1000:
                self._leave()
                continue
            before = bytes(self.uc.mem_read(self.pc - 2, 2))
            if before == b"\x30\xbf" and not self.active:
                if self._next_irq() is None:
                    return True
                continue
            if most and self._next_irq() is None:
                return False

    def period(self, most=0, late=0):
        """One period of the tick timer: raises its interrupt and runs the core. Returns False if the core hangs.

        A core that may hang runs `most` instructions.

        A late tick still runs when `late` further periods begin.
        """
        for _ in range(late):
            if self._begin():
                self.uc.ctl_flush_tb()  # or instructions that ran before are not counted
                asleep = self.run_until_sleep(LATE_INSTRUCTIONS)
                assert not asleep, f"the tick of period {self.periods} is too short to be late"
        asleep = self._begin() and self.run_until_sleep(most)
        while asleep and self._drain():
            asleep = self.run_until_sleep(most)
        return asleep

    def _drain(self):
        """The line takes the bytes that the UART holds, as many as it can within the period; returns whether an interrupt asks for more."""
        taken = min(self.FIFO_BYTES - self.send_room, self.line_bytes)
        self.send_room += taken
        self.line_bytes -= taken
        asks = self.uart_irqs() if taken else set()
        self.pending |= asks
        return bool(asks)

    def _begin(self):
        """Begins a period. Returns False if a watchdog acts instead."""
        self.periods += 1
        if any(self.periods - self.fed.get(name, self.periods) > limit for name, limit in self.watchdogs().items()):
            self.reset(by_watchdog=True)
            return False
        self.line_bytes = BYTES_IN_A_TICK
        while self.to_board and len(self.fifo) < self.FIFO_BYTES:
            self.fifo.append(self.to_board.pop(0))
        self.move_bytes()
        self._drain()
        self.pending |= self.raises() | self.uart_irqs()
        return True

    stored = traces = False
    cycles, longest_unfed, unfed = 0, 0, None
    power_fails_in = 0  # operations of the flash
    overrun = False  # whether a received byte was lost; an STM32 then receives nothing until the program clears the flag


def explain(chip, error: UcError):
    """Error message with the position of the core when Unicorn stopped."""
    pc = chip.uc.reg_read(UC_ARM_REG_PC)
    below = [(value, name) for name, value in chip.symbols.items() if value <= pc]
    return f"{error}: pc {pc:#x} in {max(below)[1] if below else 'nothing'}"
