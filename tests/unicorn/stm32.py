"""Registers of the STM32 that the images of the Nucleo boards use. Each chip is a row of `CHIPS`."""

from unicorn.arm_const import UC_CPU_ARM_CORTEX_M4, UC_CPU_ARM_CORTEX_M7

from chip import Chip

CR1, DIER, SR, EGR, CCER, CNT, ARR, CCR1, BDTR = 0x00, 0x0C, 0x10, 0x14, 0x20, 0x24, 0x2C, 0x34, 0x44  # of the timers
MODER, IDR, ODR, BSRR = 0x00, 0x10, 0x14, 0x18  # of the ports
RXNE, TC, TXE, TEACK, REACK = 1 << 5, 1 << 6, 1 << 7, 1 << 21, 1 << 22
RXNEIE, TXFEIE = 1 << 5, 1 << 30
ORE, ICR = 1 << 3, 0x20  # of the USART
DMAR, DMAT = 1 << 6, 1 << 7  # of the USART, for a DMA
NDTR, PAR, M0AR = 0x04, 0x08, 0x0C  # of a DMA's stream or channel
MOE = 1 << 15
STOP = 0  # among the inputs that are high
LSI_HZ = 32_000

KEYS = [0x4567_0123, 0xCDEF_89AB]
FLASH_START = 0x0800_0000

# Register maps: RM0433 (H743), RM0390 (F446), RM0440 (G474), the tables of section 2.
TIMERS = {"TIM2": 0x4000_0000, "TIM3": 0x4000_0400, "TIM4": 0x4000_0800, "TIM7": 0x4000_1400}
SMALL_PINS = {
    "enable": ("GPIOC", 8),
    "directions": [("GPIOB", 13), ("GPIOB", 14), ("GPIOB", 15)],
    "high": [("GPIOB", 12), ("GPIOC", 9), ("GPIOC", 10)],
}
CHIPS = {
    "h743": {
        "cpu": UC_CPU_ARM_CORTEX_M7,
        "base": TIMERS
        | {
            "USART": 0x4000_4800,
            "TIM1": 0x4001_0000,
            "IWDG": 0x5800_4800,
            "GPIOA": 0x5802_0000,
            "GPIOB": 0x5802_0400,
            "GPIOC": 0x5802_0800,
            "GPIOD": 0x5802_0C00,
            "GPIOE": 0x5802_1000,
            "GPIOF": 0x5802_1400,
            "RCC": 0x5802_4400,
            "PWR": 0x5802_4800,
        },
        # code flash, the TCMs, AXI and other SRAM
        "memory": [(0, 0x1_0000), (0x0800_0000, 0x20_0000), (0x2000_0000, 0x2_0000), (0x2400_0000, 0x8_0000), (0x3000_0000, 0x4_8000)],
        # pairs of "on" and "ready" bits in the registers of the RCC, by offset
        "ready": {
            0x00: [(0, 2), (7, 8), (12, 13), (16, 17), (24, 25), (26, 27), (28, 29)],
            0x70: [(0, 1)],
            0x74: [(0, 1)],
        },
        "clock_switch": (0x10, 3, 3),  # register, bits of the setting, place of the bits that report it
        # registers of the RCC that turn clocks on, and the bit of each peripheral that has one
        "clocks_on": range(0xD4, 0xF8),
        "clocks": {
            "TIM2": (0xE8, 0),
            "TIM3": (0xE8, 1),
            "TIM4": (0xE8, 2),
            "TIM7": (0xE8, 5),
            "USART": (0xE8, 18),
            "TIM1": (0xF0, 0),
            "GPIOA": (0xE0, 0),
            "GPIOB": (0xE0, 1),
            "GPIOC": (0xE0, 2),
            "GPIOD": (0xE0, 3),
            "GPIOE": (0xE0, 4),
            "GPIOF": (0xE0, 5),
        },
        "power": {0x04: 1 << 13 | 3 << 14, 0x18: 1 << 13, 0x0C: 1 << 16 | 1 << 25 | 1 << 26},  # bits that are always set
        "reset_cause": (0xD0, 1 << 26, 1 << 23),  # register, bit of the watchdog, bit of power-on
        "usart": (0x1C, 0x24, 0x28),  # status, received, sent
        "irq": {"TIM7": 55, "USART": 39},
        "clock_hz": 480_000_000,
        # of each bank: its flash, its registers; then offsets of KEYR and CR; bits of LOCK, PG, SER and START, place and
        # bits of the sector's number; sizes of the sectors
        "flash": ([(0x10_0000, 0x5200_2100)], 0x04, 0x0C, (0, 1, 2, 7), (8, 3), [0x2_0000] * 8),
        # stop circuit closed, supply good, operator present
        "pins": {
            "enable": ("GPIOF", 12),
            "directions": [("GPIOF", 3), ("GPIOF", 5), ("GPIOF", 10)],
            "high": [("GPIOE", 15), ("GPIOF", 13), ("GPIOF", 14)],
        },
        "values": {0x5C00_1000: 0x2003_6450},  # revision V
    },
    "f446": {
        "cpu": UC_CPU_ARM_CORTEX_M4,
        "base": TIMERS
        | {
            "WWDG": 0x4000_2C00,
            "IWDG": 0x4000_3000,
            "USART": 0x4000_4400,
            "PWR": 0x4000_7000,
            "TIM1": 0x4001_0000,
            "GPIOA": 0x4002_0000,
            "GPIOB": 0x4002_0400,
            "GPIOC": 0x4002_0800,
            "RCC": 0x4002_3800,
            "DMA1": 0x4002_6000,
        },
        "memory": [(0x0800_0000, 0x8_0000), (0x2000_0000, 0x2_0000)],
        "ready": {0x00: [(0, 1), (16, 17), (24, 25), (26, 27), (28, 29)], 0x74: [(0, 1)]},
        "clock_switch": (0x08, 2, 2),
        "clocks_on": range(0x30, 0x48),
        "clocks": {
            "TIM2": (0x40, 0),
            "TIM3": (0x40, 1),
            "TIM4": (0x40, 2),
            "TIM7": (0x40, 5),
            "WWDG": (0x40, 11),
            "USART": (0x40, 17),
            "PWR": (0x40, 28),
            "TIM1": (0x44, 0),
            "GPIOA": (0x30, 0),
            "GPIOB": (0x30, 1),
            "GPIOC": (0x30, 2),
            "DMA1": (0x30, 21),
        },
        "power": {0x04: 1 << 14 | 1 << 16 | 1 << 17},
        "reset_cause": (0x74, 1 << 29, 1 << 27),
        "usart": (0x00, 0x04, 0x04),
        "irq": {"TIM7": 55},
        # streams 5 and 6 with their settings, the second one's flags with "complete", their register and the one that clears them
        "dma": ([0x88, 0xA0], [4 << 25, 4 << 25 | 1 << 6], (0x3D << 16, 1 << 21, 0x04, 0x0C)),
        "transfer_error": 1 << 19,
        "clock_hz": 180_000_000,
        "flash": ([(0, 0x4002_3C00)], 0x04, 0x10, (31, 0, 1, 16), (3, 4), [0x4000] * 4 + [0x1_0000] + [0x2_0000] * 3),
        "window_hz": 45_000_000 / 4096,
        "pins": SMALL_PINS,
        "values": {0x4002_3C14: 0x0FFF_AAED},  # option bytes as delivered: no brown-out reset
    },
    "g474": {
        "cpu": UC_CPU_ARM_CORTEX_M4,
        "base": TIMERS
        | {
            "IWDG": 0x4000_3000,
            "USART": 0x4000_4400,
            "PWR": 0x4000_7000,
            "TIM1": 0x4001_2C00,
            "RCC": 0x4002_1000,
            "DMA1": 0x4002_0000,
            "DMAMUX": 0x4002_0800,
            "GPIOA": 0x4800_0000,
            "GPIOB": 0x4800_0400,
            "GPIOC": 0x4800_0800,
        },
        # flash, CCM for code, SRAM without the CCM, which repeats there
        "memory": [(0x0800_0000, 0x8_0000), (0x1000_0000, 0x8000), (0x2000_0000, 0x1_8000)],
        "ready": {0x00: [(8, 10), (16, 17), (24, 25)], 0x90: [(0, 1)], 0x94: [(0, 1)], 0x98: [(0, 1)]},
        "clock_switch": (0x08, 2, 2),
        "clocks_on": range(0x48, 0x64),
        "clocks": {
            "TIM2": (0x58, 0),
            "TIM3": (0x58, 1),
            "TIM4": (0x58, 2),
            "TIM7": (0x58, 5),
            "USART": (0x58, 17),
            "PWR": (0x58, 28),
            "TIM1": (0x60, 11),
            "GPIOA": (0x4C, 0),
            "GPIOB": (0x4C, 1),
            "GPIOC": (0x4C, 2),
            "DMA1": (0x48, 0),
            "DMAMUX": (0x48, 2),
        },
        "power": {},
        "reset_cause": (0x94, 1 << 29, 1 << 27),
        "usart": (0x1C, 0x24, 0x28),
        "irq": {"TIM7": 55},
        # channels 1 and 2, whose requests the multiplexer selects; "complete" stops none
        "dma": ([0x08, 0x1C], [0, 1 << 4], (1 << 7, 0, 0x00, 0x04)),
        "transfer_error": 1 << 7,
        "requests": [26, 27],
        "clock_hz": 170_000_000,
        # the highest bit of the number selects the bank
        "flash": ([(0, 0x4002_2000)], 0x08, 0x14, (31, 0, 1, 16), (3, 9), [0x800] * 0x100),
        "pins": SMALL_PINS,
        "values": {0x4002_1000: 0x500, 0x4002_2020: 1 << 22},  # the oscillator that runs after a reset; two banks
    },
}


class Stm32(Chip):
    """An STM32 by its row of `CHIPS`, with register values that differ from it."""

    def __init__(self, name, elf, values=None):
        self.row = CHIPS[name]
        self.base, self.values = self.row["base"], self.row["values"] | (values or {})
        self.MEMORY, self.CPU = self.row["memory"], self.row["cpu"]
        self.UNREADABLE_IF_TORN = name == "h743"
        self.clocks = {self.base[name]: clock for name, clock in self.row["clocks"].items()}
        self.ports = {self.base[name]: name for name in self.base if name.startswith("GPIO")}
        self.inputs = {name: sum(1 << pin for port, pin in self.row["pins"]["high"] if port == name) for name in self.ports.values()}
        super().__init__(elf)

    def reset_values(self, by_watchdog):
        register, watchdog, power = self.row["reset_cause"]
        self.too_early = False
        banks, _, cr, (lock, *_), *_ = self.row["flash"]
        self.keys, self.before, self.moves = [], None, [0, 0]
        locked = {registers + cr: 1 << lock for _, registers in banks}
        return {self.base["RCC"] + register: watchdog if by_watchdog else power} | locked | self.values

    def cycles_per_period(self):
        return self.row["clock_hz"] // 1000

    def of(self, name, offset):
        return self.at(self.base[name] + offset)

    def word(self, address, kept):
        self.too_early = self.too_early and address >= 0xE000_0000
        for axis, timer in enumerate(["TIM2", "TIM3", "TIM4"]):
            if address == self.base[timer] + CNT:
                return self.encoders[axis] & (0xFFFF_FFFF if timer == "TIM2" else 0xFFFF)
        if address & ~0x3FF == self.base["RCC"]:
            offset = address - self.base["RCC"]
            for on, ready in self.row["ready"].get(offset, []):
                kept = kept & ~(1 << ready) | (kept >> on & 1) << ready
            switch, bits, reported = self.row["clock_switch"]
            mask = (1 << bits) - 1
            return kept & ~(mask << reported) | (kept & mask) << reported if offset == switch else kept
        if address & ~0x3FF == self.base["PWR"]:
            return kept | self.row["power"].get(address - self.base["PWR"], 0)
        status, received, _ = self.row["usart"]
        if address == self.base["USART"] + status:
            came = ORE if self.overrun else RXNE if self.fifo else 0
            return (TXE if self.send_room else 0) | TC | TEACK | REACK | came
        if address == self.base["USART"] + received:
            self.overrun = self.overrun and bool(status)  # the data register clears it where there is no ICR
            return self.take_byte() if self.fifo else kept
        port = self.ports.get(address - IDR)
        if port:
            moder = self.of(port, MODER)
            driven = sum(1 << pin for pin in range(16) if moder >> (2 * pin) & 3 == 1)
            return self.of(port, ODR) & driven | self.inputs[port] & ~driven
        if address == self.base["TIM7"] + CNT:
            return 0
        return kept

    def stores(self, address, value):
        offset = address - self.base["RCC"]
        if offset in self.row["clocks_on"]:
            self.too_early |= bool(value & ~self.at(address))
        elif self.has_no_clock(address):
            self.journal.append("lost")
            return False
        banks, keyr, cr, bits, *_ = self.row["flash"]
        for first, registers in banks:
            if address == registers + keyr:
                self.keys.append(value)
                if self.keys[-2:] == KEYS:
                    self.registers[registers + cr] &= ~(1 << bits[0])
                return False
            if address == registers + cr:
                return self._flash_control(first, address, value)
        if address == self.base["USART"] + ICR and self.row["usart"][0] and value & ORE:
            self.overrun = False
        if address == self.base["USART"] + self.row["usart"][2]:
            self.send_byte(value & 0xFF)
            return False
        if "dma" in self.row and self.base["DMA1"] <= address < self.base["DMA1"] + 0x100:
            return self._dma(address, address - self.base["DMA1"], value)
        if address == self.base["IWDG"]:
            if value == 0xCCCC:
                self.fed["IWDG"] = self.periods
            if value in (0xCCCC, 0xAAAA):
                self.feed("IWDG", starts="IWDG" in self.fed)
            return False
        if address == self.base.get("WWDG") and value & 0x80:
            self.feed("WWDG")
        if address == self.base["TIM1"] + EGR:
            self.journal.append("restart")
        port = address - BSRR
        if port in self.ports:
            self.registers[port + ODR] = (self.at(port + ODR) & ~(value >> 16) | value) & 0xFFFF
            return False
        if address == self.base["TIM1"] + SR:
            self.registers[address] = self.at(address) & value  # flags are cleared by writing zero
            return False
        return True

    def _flash_control(self, first, registers, value):
        """A write to the register CR of a bank that begins at `first`."""
        _, _, _, (lock, program, erases, begin), (place, bits), sizes = self.row["flash"]
        if self.at(registers) >> lock & 1:
            return False
        first += FLASH_START
        slots = [first + sum(sizes[:-2]), sum(sizes[-2:])]
        if value >> begin & 1:
            assert value >> erases & 1, "no other operation is known"
            number = value >> place & (1 << bits) - 1
            if bits == 9:  # two banks of 128 pages: bit 8 of the number is the second one
                number = number & 0x7F | number >> 1 & 0x80
            self.erase(first + sum(sizes[:number]), sizes[number])
            self.registers[registers] = value & ~(1 << begin)  # the hardware clears it
            return False
        elif value >> program & 1:
            self.before = bytes(self.uc.mem_read(*slots))
        elif self.before:
            # the core has stored to the flash meanwhile
            before, after, self.before = self.before, bytes(self.uc.mem_read(*slots)), None
            changed = int.from_bytes(before, "little") ^ int.from_bytes(after, "little")  # byte by byte would take seconds
            if changed:
                at, end = ((changed & -changed).bit_length() - 1) // 8, (changed.bit_length() + 7) // 8
                self.uc.mem_write(slots[0] + at, before[at:end])
                self.write(slots[0] + at, after[at:end])
        return True

    def driving(self):
        port, pin = self.row["pins"]["enable"]
        pulses = self.of("TIM1", BDTR) & MOE and self.of("TIM1", CCER)
        return bool(pulses) or bool(self.of(port, ODR) >> pin & 1)

    def pins(self):
        level = lambda place: self.of(place[0], ODR) >> place[1] & 1
        steps = [self.of("TIM1", CCR1 + 4 * axis) & 0xFFFF for axis in range(3)]
        pins = self.row["pins"]
        return [level(pins["enable"]), int(bool(self.of("TIM1", BDTR) & MOE)), *steps, *map(level, pins["directions"])]

    def period_steps(self):
        return self.of("TIM1", ARR) + 1

    def watchdogs(self):
        if "IWDG" not in self.fed:
            return {}
        divider = 4 << (self.of("IWDG", 0x04) & 7)
        limits = {"IWDG": ((self.of("IWDG", 0x08) & 0xFFF) + 1) * divider / LSI_HZ * 1000}
        if "WWDG" in self.fed:
            ticks = (self.of("WWDG", 0) & 0x7F) - 0x3F
            limits["WWDG"] = ticks * (1 << (self.of("WWDG", 4) >> 7 & 3)) / self.row["window_hz"] * 1000
        return limits

    def raises(self):
        irq, raised = self.row["irq"], set()
        if self.of("TIM7", CR1) & 1 and self.of("TIM7", DIER) & 1:
            self.registers[self.base["TIM7"] + SR] = 1
            raised.add(irq["TIM7"])
        return raised

    def uart_irqs(self):
        asked = self.of("USART", CR1) if "USART" in self.row["irq"] else 0
        empty = self.send_room == self.FIFO_BYTES
        return {self.row["irq"]["USART"]} if asked & RXNEIE and (self.fifo or self.overrun) or asked & TXFEIE and empty else set()

    def has_no_clock(self, address):
        """Whether a write is lost, since the clock is off, or was enabled too few cycles ago: reading any register takes them."""
        if 0 <= address - self.base["RCC"] < 0x400 or address >= 0xE000_0000:
            return False
        register, bit = self.clocks.get(address & ~0x3FF, (None, 0))
        return self.too_early or register is not None and not self.of("RCC", register) >> bit & 1

    def _dma(self, address, offset, value):
        """A write to a register of the DMA."""
        places, settings, (flags, _, status, clear) = self.row["dma"]
        if offset == clear:
            self.registers[self.base["DMA1"] + status] = self.of("DMA1", status) & ~value
            return False
        if offset in places and value & 1:
            place = places.index(offset)
            assert not self.at(address) & 1, "it runs already"
            increment = 1 << (7 if "requests" in self.row else 10)
            circular = increment >> 2 if place == 0 else 0
            assert value == settings[place] | increment | circular | 1, f"{value:#x}"
            requests = self.row.get("requests")
            assert not requests or self.of("DMAMUX", 4 * place) == requests[place], "requests of USART2"
            assert place == 0 or not self.of("DMA1", status) & flags, "a flag keeps the stream from starting"
            assert self.at(address + PAR) == self.base["USART"] + self.row["usart"][1 + place], "the USART's data register"
            self.moves[place] = self.at(address + NDTR)
        return True

    def move_bytes(self):
        if "dma" not in self.row:
            return
        places, _, (_, complete, status, _) = self.row["dma"]
        receives, sends = [self.base["DMA1"] + place for place in places]
        while self.fifo and not self.overrun and self.of("USART", self.cr3()) & DMAR and self.at(receives) & 1:
            left = self.at(receives + NDTR)
            self.uc.mem_write(self.at(receives + M0AR) + self.moves[0] - left, bytes([self.take_byte()]))
            self.registers[receives + NDTR] = left - 1 or self.moves[0]
        if self.of("USART", self.cr3()) & DMAT and self.at(sends) & 1 and self.at(sends + NDTR):
            left = self.at(sends + NDTR)
            left -= self.send_from(self.at(sends + M0AR) + self.moves[1] - left, left)
            self.registers[sends + NDTR] = left
            if not left and complete:
                self.registers[sends] &= ~1
                self.registers[self.base["DMA1"] + status] = self.of("DMA1", status) | complete

    def fail_transfer(self):
        """The DMA that sends stops with an error, in the middle of its bytes."""
        places, _, (_, _, status, _) = self.row["dma"]
        self.registers[self.base["DMA1"] + places[1]] &= ~1
        self.registers[self.base["DMA1"] + status] = self.of("DMA1", status) | self.row["transfer_error"]

    def cr3(self):
        """The USART's third control register."""
        return 0x08 if self.row["usart"][0] else 0x14

    def stop_ticks(self):
        self.registers[self.base["TIM7"] + CR1] = 0

    def lower(self, number, is_low):
        """Pulls the input with this number in the row `high` low, or lets it rise."""
        port, pin = self.row["pins"]["high"][number]
        self.inputs[port] = self.inputs[port] & ~(1 << pin) | (0 if is_low else 1 << pin)
        if number == STOP and is_low and self.of("TIM1", BDTR) >> 12 & 1:  # the break input acts without the program
            self.registers[self.base["TIM1"] + BDTR] &= ~MOE
            self.registers[self.base["TIM1"] + SR] = self.of("TIM1", SR) | 1 << 7
