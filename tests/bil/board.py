"""The B-G431B-ESC1: an image on an emulated Cortex-M4 with models of all that it touches.

The models keep the time, in cycles of the 170 MHz clock: each access to a register takes ACCESS_CYCLES,
and the rest goes by while the core sleeps. Exceptions are taken when it sleeps or leaves another one.
"""

import struct
import tomllib

import unicorn
from unicorn import arm_const as arm

import analogue
import digital
import elf
from registers import Block, Bus, Register, WrongAccess

FLASH, FLASH_SIZE = 0x08000000, 0x20000
RAM, RAM_SIZE = 0x20000000, 0x8000
PAGE = 0x1000
ACCESS_CYCLES = 8
EXC_RETURN = 0xFFFFFFF9  # to thread mode, main stack
FRAME = [arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3,
         arm.UC_ARM_REG_R12, arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PC, arm.UC_ARM_REG_XPSR]
WATCHDOG_FLAG = 1 << 29
PIN_FLAG = 1 << 26
WFI = b"\x30\xbf"
COLD_ROOM_COUNT = 4096 * 4.7 / (4.7 + 10)  # 25 °C: an NTC of 10 kΩ above 4.7 kΩ


class Chip:
    """All that the core sees beside its memories."""

    def __init__(self, reset_flags):
        self.now = 0
        self.pins = {"PA1": 0.0, "PA7": 0.0, "PB0": 0.0, "PA0": 0.0, "PB14": COLD_ROOM_COUNT}
        self.power = power = digital.Power(reset_flags)
        system_clock = power.enabled("APB2ENR", 0)
        converter_clock = power.enabled("AHB2ENR", 13)
        self.ports = {
            "A": digital.Port("A", 0x48000000, 0xABFFFFFF, 0x64000000, 0x0C000000,
                              power.enabled("AHB2ENR", 0)),
            "B": digital.Port("B", 0x48000400, 0xFFFFFEBF, 0x00000100, 0,
                              power.enabled("AHB2ENR", 1)),
            "C": digital.Port("C", 0x48000800, 0xFFFFFFFF, 0, 0, power.enabled("AHB2ENR", 2)),
        }
        self.timer = digital.Timer(self, power.enabled("APB2ENR", 11))
        self.usart = digital.Usart(power.enabled("APB1ENR1", 17))
        self.watchdog = digital.Watchdog(self)
        self.system = digital.System(self)
        self.level = analogue.Level(self.comparators_changed, power.enabled("AHB2ENR", 18))
        self.comparators = analogue.Comparators(self.pins, self.level, self.comparators_changed,
                                                system_clock)
        self.amplifiers = analogue.Amplifiers(self.pins, system_clock)
        amplifier = self.amplifiers.output
        self.converters = [
            analogue.Converter(self, "ADC1", 0x50000000, {
                1: lambda: self.pins["PA0"], 3: lambda: amplifier(1, inside=False),
                5: lambda: self.pins["PB14"]}, converter_clock),
            analogue.Converter(self, "ADC2", 0x50000100, {
                3: lambda: amplifier(2, inside=False), 18: lambda: amplifier(3, inside=True)},
                converter_clock),
        ]
        common = Block("ADC12", 0x50000300, {"CCR": (0x08, Register(0, 3 << 16))}, converter_clock)
        self.timer.trigger = self._trigger
        self.timed = [self.timer, self.watchdog, self.system, *self.converters]
        self.blocks = [*power.blocks, *self.ports.values(), self.timer, self.usart, self.watchdog,
                       self.system, self.level, self.comparators, self.amplifiers,
                       *self.converters, common, digital.configuration_block(system_clock),
                       digital.debug_block()]

    def _trigger(self):
        for converter in self.converters:
            converter.trigger()

    def converters_want_interrupt(self):
        return any(converter.wants_interrupt() for converter in self.converters)

    def comparators_changed(self):
        """Outputs to the timer's break input, each by its enable and polarity."""
        selected = self.timer["AF1"]
        active = False
        for number in analogue.COMPARATORS:
            if digital.bit(selected, number):
                active |= self.comparators.output(number) != bool(digital.bit(selected, 9 + number))
        self.timer.set_break_input(active == bool(digital.bit(self.timer["BDTR"], 13)))

    def set_pins(self, **volts):
        self.pins.update(volts)
        self.comparators_changed()

    def advance(self, cycles):
        end = self.now + cycles
        while (due := min(model.due for model in self.timed)) <= end:
            self._fire(due)
        self.now = end

    def wait(self):
        """Until the next thing happens."""
        self._fire(min(model.due for model in self.timed))

    def _fire(self, due):
        if due == digital.NEVER:
            raise WrongAccess("the core sleeps, and nothing will ever wake it")
        self.now = due
        next(model for model in self.timed if model.due == due).fire()


class Core:
    """The Cortex-M4. Unicorn has no exceptions of its own: entry and return are made here."""

    def __init__(self, image, chip):
        self.chip = chip
        self.bus = Bus(chip.blocks)
        self.failure = None
        # The mode for microcontrollers would be another core, an M33.
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.uc.mem_map(FLASH, FLASH_SIZE, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        self.uc.mem_map(RAM, RAM_SIZE, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE)
        for address, data in elf.segments(image):
            self.uc.mem_write(address, data)
        for page in self.bus.pages(PAGE):
            self.uc.mmio_map(page, PAGE, self._read, page, self._write, page)
        self.uc.hook_add(unicorn.UC_HOOK_MEM_INVALID, self._invalid)
        stack, start = struct.unpack("<II", self.uc.mem_read(FLASH, 8))
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_PC, start)

    def _guarded(self, access, *arguments):
        """What goes wrong must not pass through the emulator: it is kept until that has stopped."""
        try:
            self.chip.advance(ACCESS_CYCLES)
            return access(*arguments)
        except Exception as failure:  # any: it is raised again by run()
            self.failure = self.failure or failure
            self.uc.emu_stop()
            return 0

    def _read(self, _, offset, size, page):
        return self._guarded(self.bus.read, page + offset, size)

    def _write(self, _, offset, size, value, page):
        self._guarded(self.bus.write, page + offset, size, value)

    def _invalid(self, _, kind, address, size, value, __):
        if address != EXC_RETURN & ~1:
            self.failure = self.failure or WrongAccess(
                f"access of {size} byte(s) to {address:#010x}, where there is nothing")
        return False

    def run(self, instructions=0):
        """Until the core sleeps or leaves an exception; at most so many instructions if given."""
        program = self.uc.reg_read(arm.UC_ARM_REG_PC)
        if instructions:
            self.uc.ctl_flush_tb()  # what has run before would not be counted
        try:
            self.uc.emu_start(program | 1, EXC_RETURN & ~1, count=instructions)
        except unicorn.UcError as error:
            if self.uc.reg_read(arm.UC_ARM_REG_PC) != EXC_RETURN & ~1 and self.failure is None:
                raise WrongAccess(f"{error} at {program:#010x}") from error
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure

    def handle(self, exception, instructions=0):
        """Runs the handler that the vector table names, from entry to return."""
        stack = self.uc.reg_read(arm.UC_ARM_REG_SP)
        frame = [self.uc.reg_read(register) for register in FRAME]
        pushed = stack - 32 & ~7
        self.uc.mem_write(pushed, struct.pack("<8I", *frame))
        self._enter(exception, pushed)
        self.run(instructions)
        frame = struct.unpack("<8I", self.uc.mem_read(pushed, 32))
        for register, value in zip(FRAME, frame):
            self.uc.reg_write(register, value)
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)

    def _enter(self, exception, stack):
        vector = self.chip.system["SCB_VTOR"] + 4 * exception
        handler, = struct.unpack("<I", self.uc.mem_read(vector, 4))
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_LR, EXC_RETURN)
        self.uc.reg_write(arm.UC_ARM_REG_PC, handler)

    def fault_without_stack(self, exception, instructions):
        """The handler's first instructions, with the stack pointer at the very end of the RAM."""
        self._enter(exception, RAM)
        self.run(instructions)


class Board:
    """The image from its reset vector on. Analogue values are set in counts as the drive takes them."""

    def __init__(self, image, board_file, reset_flags=PIN_FLAG):
        board = tomllib.loads(board_file.read_text(encoding="utf-8"))
        hal = board["hal"]
        self.zero = round(hal["amplifier_zero_v"] / hal["adc_reference_v"] * 4096)
        self.sign = -1 if hal["amplifier_gain"] < 0 else 1
        self.gain = hal["pga_gain"]
        self.trip_a = board["board"]["trip_a"]
        self.chip = Chip(reset_flags)
        self.core = Core(image, self.chip)

    def boot(self):
        """To the first sleep."""
        self.core.run()

    def set_inputs(self, phase_a, phase_b, bus, temperature=COLD_ROOM_COUNT):
        """What flows into phases a and b comes back out of phase c."""
        phases = (phase_a, phase_b, 3 * 2048 - phase_a - phase_b)
        volts = [(self.zero + self.sign * (count - 2048)) / self.gain for count in phases]
        self.chip.set_pins(**dict(zip(analogue.SHUNT_PINS.values(), volts)), PA0=bus,
                           PB14=temperature)

    def handle_next(self, background=0):
        """Sleeps until an exception comes, runs it, and the background back to sleep or, if given, for so many
        instructions at most: the next exception comes upon it there. Its number."""
        while (exception := self.chip.system.take()) is None:
            self.chip.wait()
        self.core.handle(exception)
        self.core.run(background)
        return exception

    def tick(self, ticks=1):
        """So many control ticks."""
        while ticks:
            ticks -= self.handle_next() == self.chip.system.ADC1_2

    def sleeps(self):
        """Whether the background has come to its end."""
        slept = self.core.uc.reg_read(arm.UC_ARM_REG_PC) - len(WFI)
        return self.core.uc.mem_read(slept, len(WFI)) == WFI

    def type(self, line):
        """A line at the console. A sleep may end for any reason: this one ends for the line."""
        self.chip.usart.typed.extend(f"{line}\r".encode())
        self.core.run()

    def said(self):
        """What the console has said since the last look."""
        said = self.chip.usart.said.decode()
        self.chip.usart.said.clear()
        return said
