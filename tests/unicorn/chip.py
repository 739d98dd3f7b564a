"""A model of the STM32H743 that is as complete as its image needs: registers, prioritised interrupts and a watchdog.

Unicorn executes the core's instructions. The model's time does not advance while they run; whenever the core
sleeps, it advances by one period of the tick timer. In a loop that never sleeps, a period lasts
PERIOD_INSTRUCTIONS instructions. The model therefore does not show how long a tick takes.
"""

import struct

from elftools.elf.elffile import ELFFile
from unicorn import UC_ARCH_ARM, UC_HOOK_CODE, UC_MODE_MCLASS, UC_MODE_THUMB, UC_PROT_ALL, Uc, UcError
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
    UC_CPU_ARM_CORTEX_M7,
)

# Register map (RM0433, tables of section 2.3): base addresses of the peripherals that the image uses.
BASE = {
    "TIM2": 0x4000_0000,
    "TIM3": 0x4000_0400,
    "TIM4": 0x4000_0800,
    "TIM7": 0x4000_1400,
    "USART3": 0x4000_4800,
    "TIM1": 0x4001_0000,
    "IWDG1": 0x5800_4800,
    "GPIOE": 0x5802_1000,
    "GPIOF": 0x5802_1400,
    "RCC": 0x5802_4400,
    "PWR": 0x5802_4800,
    "DBGMCU": 0x5C00_1000,
    "DWT": 0xE000_1000,
    "SCS": 0xE000_E000,
}
CR1, SR, CCER, CNT, CCR1, BDTR = 0x00, 0x10, 0x20, 0x24, 0x34, 0x44  # of the timers
MODER, IDR, ODR, BSRR = 0x00, 0x10, 0x14, 0x18  # of the ports
ISR, RDR, TDR = 0x1C, 0x24, 0x28  # of the UART
RXNE, TC, TXE, TEACK, REACK = 1 << 5, 1 << 6, 1 << 7, 1 << 21, 1 << 22
MOE = 1 << 15
# Memory: code flash, the TCMs, AXI and other SRAM.
MEMORY = [(0x0000_0000, 0x1_0000), (0x0800_0000, 0x20_0000), (0x2000_0000, 0x2_0000), (0x2400_0000, 0x8_0000), (0x3000_0000, 0x4_8000)]
READY = {  # pairs of "on" and "ready" bits in the registers of the RCC, by offset
    0x00: [(0, 2), (7, 8), (12, 13), (16, 17), (24, 25), (26, 27), (28, 29)],
    0x70: [(0, 1)],
    0x74: [(0, 1)],
}
LSI_HZ = 32_000
TIM7_IRQ, USART3_IRQ = 55, 39
RXNEIE = 1 << 5
BYTES_IN_A_TICK = 11  # at 115 200 baud
FIFO_BYTES = 16
PERIOD_INSTRUCTIONS = 480_000
RETURN = 0x1FFF_0000  # stands for an exception return; the page is executable
FRAME = [UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_XPSR]


class Chip:
    """A chip with an image in its flash."""

    def __init__(self, elf):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M7)
        for start, size in MEMORY:
            self.uc.mem_map(start, size, UC_PROT_ALL)
        with open(elf, "rb") as file:
            image = ELFFile(file)
            for segment in image.iter_segments():
                if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]:
                    self.uc.mem_write(segment["p_paddr"], segment.data())
            table = image.get_section_by_name(".symtab")
            self.symbols = {symbol.name: symbol["st_value"] & ~1 for symbol in table.iter_symbols() if symbol["st_value"]}
            self.vectors = image.get_section_by_name(".vector_table")["sh_addr"]
        self.uc.mmio_map(0x4000_0000, 0x2000_0000, self._read, 0x4000_0000, self._write, 0x4000_0000)
        self.uc.mmio_map(0xE000_0000, 0x10_0000, self._read, 0xE000_0000, self._write, 0xE000_0000)
        self.uc.mem_map(RETURN, 0x1000, UC_PROT_ALL)
        self.uc.mem_write(RETURN, b"\x00\xbf" * 0x800)
        self.uc.hook_add(UC_HOOK_CODE, lambda *_: self.uc.emu_stop(), begin=RETURN, end=RETURN + 0xFFF)
        self.encoders = [0, 0, 0]
        self.inputs = {"GPIOE": 1 << 15, "GPIOF": 1 << 13 | 1 << 14}  # stop circuit closed, supply good, operator present
        self.to_board, self.fifo, self.taken, self.sent = bytearray(), bytearray(), bytearray(), bytearray()
        self.periods = 0
        self.journal = []
        self.resets = 0
        self.reset(by_watchdog=False)

    def reset(self, by_watchdog):
        """Sets every register to its reset value; RAM keeps its content."""
        self.registers = {BASE["RCC"] + 0xD0: 1 << 26 if by_watchdog else 1 << 23, BASE["DBGMCU"]: 0x2003_6450}
        self.enabled, self.pending, self.active = set(), set(), []
        self.fed, self.watchdog = None, None
        self.fifo.clear()
        self.resets += 1
        stack, entry = struct.unpack("<II", self.uc.mem_read(self.vectors, 8))
        self.uc.reg_write(UC_ARM_REG_PRIMASK, 0)
        self.uc.reg_write(UC_ARM_REG_SP, stack)
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24)
        self.pc = entry & ~1

    # registers

    def _of(self, name, offset):
        return self.registers.get(BASE[name] + offset, 0)

    def _read(self, _uc, offset, size, base):
        address = base + offset
        word = self._word(address & ~3) >> (8 * (address & 3))
        return word & ((1 << (8 * size)) - 1)

    def _word(self, address):
        kept = self.registers.get(address, 0)
        for axis, timer in enumerate(["TIM2", "TIM3", "TIM4"]):
            if address == BASE[timer] + CNT:
                return self.encoders[axis] & (0xFFFF_FFFF if timer == "TIM2" else 0xFFFF)
        if address & ~0x3FF == BASE["RCC"]:
            offset = address - BASE["RCC"]
            for on, ready in READY.get(offset, []):
                kept = kept & ~(1 << ready) | (kept >> on & 1) << ready
            return kept & ~0x38 | (kept & 7) << 3 if offset == 0x10 else kept  # the clock switch reports its setting
        if address & ~0x3FF == BASE["PWR"]:
            offset = address - BASE["PWR"]
            return kept | {0x04: 1 << 13 | 3 << 14, 0x18: 1 << 13, 0x0C: 1 << 16 | 1 << 25 | 1 << 26}.get(offset, 0)
        if address == BASE["USART3"] + ISR:
            return TXE | TC | TEACK | REACK | (RXNE if self.fifo else 0)
        if address == BASE["USART3"] + RDR and self.fifo:
            self.taken.append(self.fifo[0])
            return self.fifo.pop(0)
        for port in ["GPIOE", "GPIOF"]:
            if address == BASE[port] + IDR:
                moder = self._of(port, MODER)
                driven = sum(1 << pin for pin in range(16) if moder >> (2 * pin) & 3 == 1)
                return self._of(port, ODR) & driven | self.inputs[port] & ~driven
        if address == BASE["TIM7"] + CNT:
            return 0
        if address == BASE["DWT"] + 0x04:  # cycles are not counted, but a constant clock would make delays endless
            self.registers[address] = (self.periods * 480_000 + kept % 480_000 + 64) & 0xFFFF_FFFF
            return self.registers[address]
        return kept

    def _write(self, _uc, offset, size, value, base):
        address = base + offset
        word, shift = address & ~3, 8 * (address & 3)
        mask = ((1 << (8 * size)) - 1) << shift
        value = self.registers.get(word, 0) & ~mask | value << shift & mask
        scs = word - BASE["SCS"]
        if 0x100 <= scs < 0x120:
            self.enabled |= {32 * (scs - 0x100) // 4 + bit for bit in range(32) if value >> bit & 1}
        elif 0x180 <= scs < 0x1A0:
            self.enabled -= {32 * (scs - 0x180) // 4 + bit for bit in range(32) if value >> bit & 1}
        elif 0x200 <= scs < 0x220:
            self.pending |= {32 * (scs - 0x200) // 4 + bit for bit in range(32) if value >> bit & 1}
            self._stop()
        elif 0x280 <= scs < 0x2A0:
            self.pending -= {32 * (scs - 0x280) // 4 + bit for bit in range(32) if value >> bit & 1}
        elif scs == 0xF00:
            self.pending.add(value & 0x1FF)
            self._stop()
        elif word == BASE["USART3"] + TDR:
            self.sent.append(value & 0xFF)
        elif word == BASE["IWDG1"]:
            if value == 0xCCCC:
                self.watchdog = True
            if value in (0xCCCC, 0xAAAA):
                self.fed = self.periods
                self.journal.append("fed")
        elif word - BASE["GPIOE"] in (BSRR, BSRR + 0x400):
            port = word - BSRR
            odr = self.registers.get(port + ODR, 0)
            self.registers[port + ODR] = (odr & ~(value >> 16) | value) & 0xFFFF
        else:
            if word == BASE["TIM1"] + SR:
                value &= self.registers.get(word, 0)  # flags are cleared by writing zero
            self.registers[word] = value
        if word in (BASE["TIM1"] + BDTR, BASE["GPIOF"] + BSRR) and self.driving():
            self.journal.append("driving")

    def _stop(self):
        if self._next_irq() is not None:
            self.stored = True
            self.uc.emu_stop()

    def driving(self):
        """Whether a force could act: the main output or the enable line is on."""
        pulses = self._of("TIM1", BDTR) & MOE and self._of("TIM1", CCER)
        return bool(pulses) or bool(self._of("GPIOF", ODR) >> 12 & 1)

    def pins(self):
        """States of the enable line, the main output, the compare registers and the direction pins."""
        odr = self._of("GPIOF", ODR)
        steps = [self._of("TIM1", CCR1 + 4 * axis) & 0xFFFF for axis in range(3)]
        return [odr >> 12 & 1, int(bool(self._of("TIM1", BDTR) & MOE)), *steps, *[odr >> pin & 1 for pin in (3, 5, 10)]]

    def period_steps(self):
        """Number of timer steps per PWM period, as the image has set it."""
        return self._of("TIM1", 0x2C) + 1

    def watchdog_periods(self):
        """Time limit of the watchdog in periods of the tick timer."""
        divider = 4 << (self._of("IWDG1", 0x04) & 7)
        return ((self._of("IWDG1", 0x08) & 0xFFF) + 1) * divider / LSI_HZ * 1000

    # interrupts

    def _priority(self, irq):
        return self.registers.get(BASE["SCS"] + 0x400 + (irq & ~3), 0) >> (8 * (irq & 3)) & 0xFF

    def _next_irq(self):
        if self.uc.reg_read(UC_ARM_REG_PRIMASK) & 1:
            return None
        waiting = [(self._priority(irq), irq) for irq in self.pending & self.enabled]
        running = min((self._priority(irq) for irq in self.active), default=256)
        return min(waiting)[1] if waiting and min(waiting)[0] < running else None

    def _enter(self, irq):
        """Enters an interrupt: stacks core and floating-point registers, as without lazy stacking."""
        self.pending.discard(irq)
        self.active.append(irq)
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

    # time

    def run_until_sleep(self, most=0):
        """Runs until the core sleeps or, if `most` is not 0, for at most that many instructions; returns whether it sleeps."""
        while True:
            irq = self._next_irq()
            if irq is not None:
                self._enter(irq)
            self.uc.emu_start(self.pc | 1, 0xFFFF_FFFE, count=most)
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

    def period(self, hangs=False):
        """One period of the tick timer: raises its interrupt and runs the core. Returns False if the core hangs."""
        self.periods += 1
        while self.to_board and len(self.fifo) < FIFO_BYTES and BYTES_IN_A_TICK > self.moved:
            self.fifo.append(self.to_board.pop(0))
            self.moved += 1
        self.moved = 0
        if self._of("TIM7", CR1) & 1 and self._of("TIM7", 0x0C) & 1:
            self.registers[BASE["TIM7"] + SR] = 1
            self.pending.add(TIM7_IRQ)
        if self.fifo and self._of("USART3", CR1) & RXNEIE:
            self.pending.add(USART3_IRQ)
        slept = self.run_until_sleep(PERIOD_INSTRUCTIONS if hangs else 0)
        if self.watchdog and self.periods - self.fed > self.watchdog_periods():
            self.reset(by_watchdog=True)
        return slept

    moved, stored = 0, False


def explain(chip, error: UcError):
    """Error message with the position of the core when Unicorn stopped."""
    pc = chip.uc.reg_read(UC_ARM_REG_PC)
    below = [(value, name) for name, value in chip.symbols.items() if value <= pc]
    return f"{error}: pc {pc:#x} in {max(below)[1] if below else 'nothing'}"
