"""Registers of the RP2350 that the image of the Pico 2 uses (RP2350 data sheet, the register tables of each chapter)."""

import struct

from unicorn import UC_HOOK_CODE
from unicorn.arm_const import UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_CPU_ARM_CORTEX_M33

from chip import SYSTICK, Chip

RESETS, CLOCKS, IO, XOSC, PLL_SYS, PLL_USB = 0x4002_0000, 0x4001_0000, 0x4002_8000, 0x4004_8000, 0x4005_0000, 0x4005_8000
UART, PWM, TIMER, WATCHDOG, ROSC, PIO, SIO = 0x4007_0000, 0x400A_8000, 0x400B_0000, 0x400D_8000, 0x400E_8000, 0x5020_0000, 0xD000_0000
SYST_CSR, SYST_CALIB_HZ = 0xE000_E010, 150_000_000
DR, FR, IMSC = 0x00, 0x18, 0x38  # of the UART
ALIASES = 0x3000  # bits of an address that select plain, exclusive or, set and clear writes
SLICE = 0x14  # bytes between the registers of two PWM slices
CTR, CC, TOP = 0x08, 0x0C, 0x10
ENABLE, MAGNITUDES, DIRECTIONS = 22, [16, 18, 20], [17, 19, 21]
INPUTS = [28, 26, 27]  # stop circuit closed, supply good, operator present
HIGH = sum(1 << pin for pin in INPUTS)
UART_IRQ = 33
BOOT_RAM, RETURNS = 0x400E_0000, 0x4770_4770  # where the boot ROM leaves a function that starts the flash; `bx lr`, twice
VERSION, LOOKUP, FUNCTIONS = 0x13, 0x16, 0x100  # in the boot ROM
FLASH_START = 0x1000_0000
LOW, HIGH_OVER = 2, 3  # of OUTOVER


class Rp2350(Chip):
    """The RP2350, with one core."""

    MEMORY = [(0, 0x1_0000), (0x1000_0000, 0x40_0000), (0x2000_0000, 0x8_4000)]
    REGISTERS = [*Chip.REGISTERS, (SIO, 0x10_0000)]
    CPU = UC_CPU_ARM_CORTEX_M33
    FIFO_BYTES = 32

    def __init__(self, elf):
        super().__init__(elf)
        self.uc.mem_write(VERSION, b"\x02")
        self.uc.mem_write(LOOKUP, struct.pack("<H", FUNCTIONS | 1))
        names = [b"IF", b"EX", b"RE", b"RP", b"FC"]
        self.places = {struct.unpack("<H", name)[0]: FUNCTIONS + 16 * (1 + n) for n, name in enumerate(names)}
        for place in [FUNCTIONS, *self.places.values()]:
            self.uc.mem_write(place, struct.pack("<I", RETURNS))
        self.uc.hook_add(UC_HOOK_CODE, self._rom, begin=FUNCTIONS, end=max(self.places.values()))

    def _rom(self, _uc, place, *_):
        """A function of the boot ROM: looks another one up, or erases or programs the flash."""
        first, second, third = [self.uc.reg_read(register) for register in (UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2)]
        if place == FUNCTIONS:
            self.uc.reg_write(UC_ARM_REG_R0, self.places[first] | 1)
        elif place == self.places[0x4552]:  # "RE"
            self.erase(FLASH_START + first, second)
        elif place == self.places[0x5052]:  # "RP"
            self.write(FLASH_START + first, bytes(self.uc.mem_read(second, third)))

    def reset_values(self, by_watchdog):
        self.inputs, self.levels, self.outputs = HIGH, 0, 0
        return {RESETS: 0x1FFF_FFFF, WATCHDOG + 0x08: int(by_watchdog)}

    def cycles_per_period(self):
        return SYST_CALIB_HZ // 1000

    def place(self, address):
        return address & ~ALIASES if 0x4000_0000 <= address < 0x6000_0000 else address

    def merged(self, word, size, shift, value):
        if not 0x4000_0000 <= word < 0x6000_0000:
            return super().merged(word, size, shift, value)
        value = value * {1: 0x0101_0101, 2: 0x1_0001, 4: 1}[size] & 0xFFFF_FFFF  # a narrow write is repeated
        old = self.at(self.place(word))
        return [value, old ^ value, old | value, old & ~value][word >> 12 & 3] & 0xFFFF_FFFF

    def over(self, pin):
        return self.at(IO + 4 + 8 * pin) >> 12 & 3

    def word(self, address, kept):
        clock = address - CLOCKS
        if BOOT_RAM <= address < BOOT_RAM + 0x100:
            return RETURNS
        if address == RESETS + 8:
            return ~self.at(RESETS) & 0x1FFF_FFFF
        if address == XOSC + 4:
            return 1 << 31 | 1 << 12
        if address in (PLL_SYS, PLL_USB, ROSC + 0x1C):
            return kept | 1 << 31
        if clock in (0x38, 0x44):  # the switches of reference and system clock report their setting
            return 1 << (self.at(address - 8) & (3 if clock == 0x38 else 1))
        if 0 <= clock < 0x90 and clock % 12 == 8:
            return kept or 1
        if address == UART + FR:
            return 1 << 7 | (0 if self.fifo else 1 << 4) | (0 if self.send_room else 1 << 5)
        if address == UART + DR and self.fifo:
            return self.take_byte()
        if address == PIO + 4:  # no queue is empty
            return 0
        if PIO + 0x20 <= address < PIO + 0x2C:
            return self.encoders[(address - PIO - 0x20) // 4] & 0xFFFF_FFFF
        if address == SIO + 4:
            levels = self.inputs & ~self.outputs | self.levels & self.outputs
            for pin in range(30):
                if self.at(IO + 4 + 8 * pin) & 31 == 4 or self.over(pin) == LOW:
                    levels &= ~(1 << pin)
                elif self.over(pin) == HIGH_OVER:
                    levels |= 1 << pin
            return levels
        if address == SIO + 0x10:
            return self.levels
        if address in (TIMER + 0x0C, TIMER + 0x28):
            return self.periods * 1000
        return kept

    def stores(self, address, value):
        sio = {0x10: "levels", 0x18: "levels", 0x20: "levels", 0x28: "levels", 0x30: "outputs", 0x38: "outputs", 0x40: "outputs"}
        name = sio.get(address - SIO)
        if name:
            kind = (address - SIO - (0x10 if name == "levels" else 0x30)) // 8
            old = getattr(self, name)
            setattr(self, name, [value, old | value, old & ~value, old ^ value][kind])
            return False
        if address == UART + DR:
            self.send_byte(value & 0xFF)
            return False
        if address == WATCHDOG + 4:
            self.load_us = value
            self.feed("watchdog")
        if address - PWM in [axis * SLICE + CTR for axis in range(3)]:
            self.journal.append("restart")
        return True

    def driving(self):
        pulses = [self.at(PWM + axis * SLICE + CC) & 0xFFFF and self.over(pin) != LOW for axis, pin in enumerate(MAGNITUDES)]
        return bool(self.levels >> ENABLE & 1) or any(pulses)

    def pins(self):
        opened = int(any(self.over(pin) != LOW for pin in MAGNITUDES))
        steps = [self.at(PWM + axis * SLICE + CC) & 0xFFFF for axis in range(3)]
        return [self.levels >> ENABLE & 1, opened, *steps, *[self.levels >> pin & 1 for pin in DIRECTIONS]]

    def period_steps(self):
        return self.at(PWM + TOP) + 1

    def watchdogs(self):
        return {"watchdog": self.load_us / 1000} if self.at(WATCHDOG) >> 30 & 1 else {}

    def raises(self):
        return {SYSTICK} if self.at(SYST_CSR) & 3 == 3 else set()

    def uart_irqs(self):
        mask = self.at(UART + IMSC)
        return {UART_IRQ} if self.fifo and mask & 0x50 or mask & 0x20 else set()

    def stop_ticks(self):
        self.registers[SYST_CSR] = 0

    def lower(self, number, is_low):
        pin = INPUTS[number]
        self.inputs = self.inputs & ~(1 << pin) | (0 if is_low else 1 << pin)
