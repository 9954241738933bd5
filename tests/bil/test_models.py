# SPDX-License-Identifier: MIT
"""target.loop.models: the models of the chip by themselves, without an image, also for boards of which none is built here."""

import sys
import tomllib
import unittest
from pathlib import Path

import analogue
import board
import digital
import g4
import wiring
from flash import BSY, KEYS, LOCK, OPTLOCK, PER, STRT
from registers import Bus, WrongAccess

MOE, BKE, BKP, OSSI, OSSR = 1 << 15, 1 << 12, 1 << 13, 1 << 10, 1 << 11
DEAD_TIME = 100
US = 170  # cycles
ALTERNATE = 2

# One input and one enable for each leg, a fault line, and amplifiers of its own on the board.
WITH_ENABLES = {
    "chip": "stm32g474ce", "crystal_hz": 24000000,
    "gate_high_pins": ["PA9", "PA8", "PA10"], "gate_enable_pins": ["PA12", "PB13", "PB15"],
    "shunt_pins": ["PA0", "PA1", "PB1"], "bus_pin": "PB11", "temperature_pin": "PB14", "serial_pins": ["PA2", "PA3"],
    "break_pin": "PB12", "break_polarity": "active_low", "pga_gain": 1, "high_pins": ["PC6"], "low_pins": ["PC4"],
}
# The comparators and amplifiers that only the larger chips have.
WITH_UPPER_PARTS = {
    "chip": "stm32g474re",
    "gate_high_pins": ["PA8", "PA9", "PA10"], "gate_low_pins": ["PA7", "PB0", "PB1"],
    "shunt_pins": ["PB13", "PB11", "PB14"], "shunt_ground_pins": ["PB10", "PA1", "PB15"],
    "bus_pin": "PC0", "temperature_pin": "PC1", "serial_pins": ["PA2", "PA3"], "break_polarity": "active_low", "pga_gain": 16,
}
OF_G474 = tomllib.loads((Path(__file__).parents[2] / "host_sim/boards/g474_in_line.toml").read_text(encoding="utf-8"))["hal"]
OF_ESC1 = tomllib.loads((Path(__file__).parents[2] / "host_sim/boards/b_g431b_esc1.toml").read_text(encoding="utf-8"))["hal"]


class Bare:
    """A chip without a core: the registers by their names."""

    def __init__(self, hal, baud=921600, crystal_hz=None):
        self.wiring = wiring.Wiring(hal | {"high_pins": [], "low_pins": []})  # no gate driver has to wake up
        crystal_hz = self.wiring.crystal_hz if crystal_hz is None else crystal_hz
        self.chip = board.Chip(self.wiring, board.PIN_FLAG, analogue.Parts(analogue.ideal), baud, crystal_hz)
        self.bus = Bus(self.chip.blocks)
        self.addresses = {f"{block.name}_{key}": address for block in self.chip.blocks
                          for address, (key, _) in block.by_address.items()}
        for register in ("AHB2ENR", "APB1ENR1", "APB1ENR2", "APB2ENR"):
            self.write(f"RCC_{register}", self.chip.power.rcc.register(register).writable)

    def write(self, name, value):
        self.bus.write(self.addresses[name], 4, value)

    def read(self, name):
        return self.bus.read(self.addresses[name], 4)

    def wait(self, cycles):
        self.chip.advance(cycles)

    def wait_for(self, name, bits):
        for _ in range(1000):
            if self.read(name) & bits == bits:
                return
            self.wait(10 * US)
        raise AssertionError(f"{name} does not get {bits:#x}")

    def raise_power(self):
        self.write("PWR_CR5", 0)
        self.wait(50 * US)
        self.read("PWR_SR2")
        self.write("FLASH_ACR", 0x40000 | 4)

    def start_pll(self, source, divider):
        self.write("RCC_PLLCFGR", source | divider - 1 << 4 | 85 << 8 | 1 << 24)
        self.write("RCC_CR", self.read("RCC_CR") | digital.PLLON)
        self.wait_for("RCC_CR", digital.PLLRDY)
        self.write("RCC_CFGR", 8 << 4 | 3)
        self.wait(2 * US)
        self.write("RCC_CFGR", 3)

    def start_crystal(self):
        self.write("RCC_CR", self.read("RCC_CR") | digital.HSEON)
        self.wait_for("RCC_CR", digital.HSERDY)

    def run_on_crystal(self, divider):
        self.raise_power()
        self.start_crystal()
        self.start_pll(digital.FROM_CRYSTAL, divider)

    def set_function(self, pin):
        port, number = wiring.port_and_number(pin.name)
        block = self.chip.ports[port]
        block["MODER"] = block["MODER"] & ~(3 << 2 * number) | ALTERNATE << 2 * number
        block["AFRH" if number > 7 else "AFRL"] |= pin.function << 4 * (number % 8)


class Facts(unittest.TestCase):
    """Some that are known from the manual and from the board."""

    def test_memories(self):
        for name, ram, flash, dual in (("stm32g431cb", 32, 128, False), ("stm32g474ce", 128, 512, True)):
            facts = g4.facts(name)
            self.assertEqual((facts.ram_bytes, facts.flash_bytes, facts.page_bytes, facts.dual_bank),
                             (ram * 1024, flash * 1024, 2048, dual))

    def test_the_parts_at_the_esc1s_pins(self):
        found = wiring.Wiring(OF_ESC1)
        self.assertEqual(found.comparators, [1, 2, 4])
        self.assertEqual(found.amplifiers, [1, 2, 3])
        self.assertEqual([found.level_of(phase) for phase in range(3)], [("DAC3", 1), ("DAC3", 2), ("DAC3", 2)])
        self.assertEqual(found.serial, "USART2")
        self.assertEqual([pin.function for pin in found.alternates], [6, 6, 6, 4, 6, 4, 7, 7, 1, 2, 2, 2])
        self.assertEqual([found.facts.channel_of("ADC1", pin) for pin in ("PA0", "PA2", "PB14")], [1, 3, 5])


class Outputs(unittest.TestCase):
    """RM0440 28.6 (CCER), the table of output control bits, for legs with an enable."""

    def setUp(self):
        self.bare = Bare(WITH_ENABLES)
        self.timer = self.bare.chip.timer
        for name, value in {"TIM1_CCMR1": 0x6868, "TIM1_CCMR2": 0x68, "TIM1_CCER": 0x999, "TIM1_AF1": 1 | 1 << 9,
                            "TIM1_ARR": 4250, "TIM1_RCR": 1}.items():
            self.bare.write(name, value)
        self.bare.set_function(self.bare.wiring.break_line)
        self.bare.write("TIM1_BDTR", OSSI | OSSR | BKE | BKP | DEAD_TIME)

    def enable(self):
        self.bare.write("TIM1_BDTR", self.bare.read("TIM1_BDTR") | MOE)

    def test_the_enables_are_high_while_the_main_output_is_on_and_low_before(self):
        self.bare.wait(10 * US)
        self.assertEqual(self.timer.enables(), (0, 0, 0))
        self.enable()
        self.assertEqual(self.timer.enables(), (1, 1, 1))
        self.assertEqual(self.timer.output(1, False), "pwm")

    def test_a_break_lets_them_fall_behind_a_dead_time(self):
        self.enable()
        self.bare.chip.set_fault_line(0)
        self.assertFalse(self.timer.gates_on())
        self.assertEqual(self.timer.enables(), (1, 1, 1))
        self.assertEqual(self.timer.output(1, False), 0)
        self.bare.wait((DEAD_TIME + 1) * self.bare.chip.power.cycle)
        self.assertEqual(self.timer.enables(), (0, 0, 0))

    def test_without_ossr_the_timer_does_not_drive_them(self):
        self.bare.write("TIM1_BDTR", OSSI | BKE | BKP | MOE)
        self.assertEqual(self.timer.enables(), (None, None, None))

    def test_without_ossi_nothing_is_driven_before(self):
        self.bare.write("TIM1_BDTR", OSSR | BKE | BKP)
        self.assertEqual(self.timer.enables(), (None, None, None))

    def test_the_fault_line_acts_only_at_a_pin_with_its_function(self):
        self.enable()
        port, number = wiring.port_and_number(self.bare.wiring.break_line.name)
        self.bare.chip.ports[port]["MODER"] |= 3 << 2 * number
        self.bare.chip.set_fault_line(1)
        self.assertFalse(self.timer.gates_on())

    def test_the_timer_does_not_start_with_outputs_of_another_kind_or_without_the_fault_line(self):
        self.bare.write("TIM1_CR1", 1 | 1 << 5 | 1 << 7)
        for name, value, why in (("TIM1_CCER", 0x111, "polarity of the board"), ("TIM1_AF1", 0, "break pin")):
            with self.subTest(why):
                self.setUp()
                self.bare.write(name, value)
                with self.assertRaisesRegex(WrongAccess, why):
                    self.bare.write("TIM1_CR1", 1 | 1 << 5)

    def test_each_phase_has_its_own_channel(self):
        for channel in (1, 2, 3):
            self.bare.write(f"TIM1_CCR{channel}", 100 * channel)
        self.assertEqual(self.timer.preloaded(), (200, 100, 300))

    def test_a_gate_driver_tells_of_a_fault_until_its_pins_have_had_their_levels_for_its_wake_up_time(self):
        chip = self.bare.chip
        chip.wiring.held, chip.wiring.wake_s = {"PC6": 1}, 100e-6
        for write, awake in ((("GPIOC_BSRR", 1 << 6), False), (("GPIOC_MODER", 1 << 12), False)):
            self.bare.write(*write)
            self.assertEqual(chip.driver_is_awake(), awake)
        self.bare.wait(100 * US - 1)
        self.assertFalse(chip.driver_is_awake())
        self.bare.wait(1)
        self.assertTrue(chip.driver_is_awake())
        self.bare.write("GPIOC_BSRR", 1 << 22)
        self.assertFalse(chip.driver_is_awake())


class UpperParts(unittest.TestCase):
    """Comparators 5 to 7, amplifiers 4 to 6 and converters 3 to 5."""

    def setUp(self):
        self.bare = Bare(WITH_UPPER_PARTS)
        self.bare.raise_power()
        self.bare.start_pll(digital.FROM_OSCILLATOR, 4)

    def start_comparators(self, level):
        for channel in (1, 2):
            self.bare.write(f"DAC4_DHR12R{channel}", level)
        self.bare.write("DAC4_MCR", 3 | 3 << 16 | 2 << 14)
        self.bare.write("DAC4_CR", 1 | 1 << 16)
        self.bare.wait(20 * US)
        for number in self.bare.wiring.comparators:
            self.bare.write(f"COMP_{number}_CSR", 1 | 4 << 4 | 1 << 15)  # it is inverted here, for the timer cannot
        self.bare.wait(20 * US)

    def test_each_opens_the_main_output(self):
        self.assertEqual(self.bare.wiring.comparators, [5, 6, 7])
        self.bare.chip.set_pins(**dict.fromkeys(self.bare.wiring.shunts, 1000))
        self.start_comparators(500)
        self.bare.write("TIM1_AF1", 1 << 5 | 1 << 6 | 1 << 7)
        self.bare.write("TIM1_CCER", 0x555)
        for pin in self.bare.wiring.shunts:
            self.bare.write("TIM1_SR", 0)
            self.bare.write("TIM1_BDTR", BKE | BKP | MOE)
            self.assertTrue(self.bare.chip.timer.gates_on())
            self.bare.chip.set_pins(**{pin: 400})
            self.assertFalse(self.bare.chip.timer.gates_on())
            self.bare.chip.set_pins(**{pin: 1000})

    def test_an_amplifier_is_converted_inside_the_chip_by_its_converter(self):
        pga = 1 | 2 << 5 | 1 << 8 | (8 | 3) << 14
        self.bare.chip.set_pins(PB13=10, PB14=30)
        for number in (4, 5):
            self.bare.write(f"OPAMP_{number}_CSR", pga)
        self.bare.wait(10 * US)
        self.assertEqual(self.bare.chip.input("ADC5", 5), 160)
        self.assertEqual(self.bare.chip.input("ADC5", 3), 480)
        self.assertEqual(self.bare.chip.input("ADC1", 6), 0)  # the bus, at a pin
        for channel, why in ((13, "no shunt can be at its input"), (12, "does not amplify a shunt"), (4, "nothing is connected")):
            with self.assertRaisesRegex(WrongAccess, why):
                self.bare.chip.input("ADC1", channel)

    def test_a_shunt_that_is_to_be_amplified_is_not_converted_as_it_is(self):
        with self.assertRaisesRegex(WrongAccess, "nothing is connected"):
            self.bare.chip.input("ADC3", 5)

    def test_an_amplifier_with_another_ground_is_found(self):
        self.bare.wiring.grounds[0] = "PC5"
        self.bare.write("OPAMP_4_CSR", 1 | 2 << 5 | 1 << 8 | 8 << 14)
        self.bare.wait(10 * US)
        with self.assertRaisesRegex(WrongAccess, "the shunt's ground is at another pin"):
            self.bare.chip.input("ADC5", 5)
        self.bare.wiring.grounds[0] = "PB10"

    def test_each_converter_has_its_interrupt(self):
        system = self.bare.chip.system
        self.assertEqual({exception - system.DEVICE: [converter.name for converter in converters]
                          for exception, converters in system.conversions.items()},
                         {18: ["ADC1", "ADC2"], 47: ["ADC3"], 61: ["ADC4"], 62: ["ADC5"]})
        fourth = self.bare.chip.converters[3]
        fourth["IER"], fourth["ISR"] = 0x40, 0x40
        self.assertIsNone(system.first(board.THREAD))
        self.bare.write("SYSTEM_NVIC_ISER1", 1 << 61 - 32)
        self.bare.write("SYSTEM_NVIC_IPR15", 0x20 << 8)
        self.assertEqual(system.first(board.THREAD), 16 + 61)
        self.assertEqual(system.priority(16 + 61), 0x20)


class Flash(unittest.TestCase):
    def test_with_two_banks_the_store_is_at_the_end_of_the_second_and_an_erase_takes_its_time_beside_the_core(self):
        bare = Bare(WITH_UPPER_PARTS)
        flash = bare.chip.power.flash
        self.assertEqual(flash.kept_address, 0x0807C000)
        flash.load(0x0807F800, b"x" * 8)
        bare.write("FLASH_ACR", 0x40000)
        for key in KEYS:
            bare.write("FLASH_KEYR", key)
        with self.assertRaisesRegex(WrongAccess, "another page"):
            bare.write("FLASH_CR", PER | 127 << 3 | STRT)
        bare.write("FLASH_CR", PER | 127 << 3 | 1 << 11 | STRT)
        self.assertTrue(bare.read("FLASH_SR") & BSY)
        bare.wait(digital.cycles(25e-3))
        self.assertFalse(bare.read("FLASH_SR") & BSY)
        self.assertEqual(flash.content(), [])
        self.assertEqual(flash["CR"] & (LOCK | OPTLOCK), OPTLOCK)


RISE_FALL, BOTH_OF_FIRST, ENCODER = 0x31, 1 | 7 << 4 | 2 << 8, 0x5151
RING = 1 | 1 << 5 | 1 << 7 | 2 << 8 | 2 << 10


class Captures(unittest.TestCase):
    """RM0440 29.4.6, input capture; 12, DMA; 13, its multiplexer."""

    def setUp(self):
        self.bare = Bare(OF_ESC1)
        self.chip = self.bare.chip
        self.chip.bus, self.memory = self.bare.bus, {}
        self.chip.memory = self.memory.__setitem__
        self.cycle = self.chip.power.cycle
        self.bare.write("RCC_AHB1ENR", 1 | 1 << 2)
        self.bare.set_function(self.bare.wiring.pulse)
        for name, value in (("CCMR1", BOTH_OF_FIRST), ("CCER", RISE_FALL), ("DIER", 0x600), ("CR1", 1)):
            self.bare.write(f"TIM2_{name}", value)

    def start_ring(self, number, slots):
        for name, value in ((f"DMA1_CNDTR{number}", slots), (f"DMA1_CPAR{number}", 0x40000030 + 4 * number),
                            (f"DMA1_CMAR{number}", 0x20000000 + 256 * number), (f"DMAMUX1_C{number - 1}CR", 55 + number),
                            (f"DMA1_CCR{number}", RING)):
            self.bare.write(name, value)

    def pulse(self, cycles):
        for level in (1, 0):
            self.chip.signals.set("PA15", level)
            self.bare.wait(cycles * self.cycle)

    def test_a_level_has_to_last_for_the_filter(self):
        self.pulse(31)
        self.assertEqual(self.bare.read("TIM2_SR"), 0)
        self.pulse(33)
        self.assertEqual(self.bare.read("TIM2_SR"), 1 << 1 | 1 << 2)
        width = self.bare.read("TIM2_CCR2") - self.bare.read("TIM2_CCR1")
        self.assertEqual(width, 33)
        self.assertEqual(self.bare.read("TIM2_SR"), 0)

    def test_a_capture_that_was_not_read_is_lost_and_that_is_told(self):
        self.pulse(100)
        self.pulse(100)
        self.assertEqual(self.bare.read("TIM2_SR"), 0x606)

    def test_a_pin_without_the_function_gives_none(self):
        self.chip.ports["A"]["MODER"] |= 3 << 30
        self.pulse(100)
        self.assertEqual(self.bare.read("TIM2_SR"), 0)

    def test_the_dma_fills_a_ring_by_the_request_of_its_channel(self):
        self.start_ring(1, 3)
        for _ in range(4):
            self.pulse(100)
        self.assertEqual(sorted(self.memory), [0x20000100, 0x20000104, 0x20000108])
        self.assertEqual(self.bare.read("DMA1_CNDTR1"), 2)
        self.assertEqual(self.memory[0x20000100] - self.memory[0x20000108], 200)
        self.assertFalse(self.bare.read("TIM2_SR") & 0x202)

    def test_a_channel_that_is_enabled_is_not_changed_and_none_is_enabled_without_transfers(self):
        with self.assertRaisesRegex(WrongAccess, "for no transfers"):
            self.bare.write("DMA1_CCR1", RING)
        self.start_ring(1, 3)
        with self.assertRaisesRegex(WrongAccess, "while the channel is enabled"):
            self.bare.write("DMA1_CMAR1", 0x20000000)
        with self.assertRaisesRegex(WrongAccess, "does not fill a ring"):
            self.bare.write("DMA1_CCR2", 1)


class EncoderCounter(unittest.TestCase):
    """RM0440 29.4.20."""

    def setUp(self):
        self.bare = Bare(OF_ESC1)
        for pin in self.bare.wiring.encoder:
            self.bare.set_function(pin)
            self.bare.chip.signals.set(pin.name, 0)

    def test_input_1_before_input_2_counts_up(self):
        for name, value in (("CCMR1", ENCODER), ("SMCR", 3), ("ARR", 0xFFFF), ("CR1", 1)):
            self.bare.write(f"TIM4_{name}", value)
        counts = []
        for pin, level in (("PB6", 1), ("PB7", 1), ("PB6", 0), ("PB7", 0), ("PB7", 1), ("PB6", 1)):
            self.bare.chip.signals.set(pin, level)
            self.bare.wait(100 * self.bare.chip.power.cycle)
            counts.append(self.bare.read("TIM4_CNT"))
        self.assertEqual(counts, [1, 2, 3, 4, 3, 2])

    def test_one_that_does_not_look_at_its_inputs_is_found(self):
        for name, value in (("CCMR1", 0), ("SMCR", 3), ("CR1", 1)):
            self.bare.write(f"TIM4_{name}", value)
        with self.assertRaisesRegex(WrongAccess, "not its inputs"):
            self.bare.chip.signals.set("PB6", 1)


class Absolute(unittest.TestCase):
    """An AS5047D at an SPI."""

    def setUp(self):
        self.bare = Bare(OF_G474)
        self.encoder = self.bare.chip.absolute
        self.bare.write("SPI1_CR2", 0xF00)
        self.bare.write("SPI1_CR1", 1 | 1 << 2 | 4 << 3 | 1 << 6 | 3 << 8)
        self.bare.write("GPIOB_BSRR", 1 << 6)
        self.bare.chip.ports["B"]["MODER"] = 1 << 12
        self.bare.wait(US)

    def exchange(self, command, low=US):
        self.bare.write("GPIOB_BSRR", 1 << 22)
        self.bare.wait(low)
        self.bare.write("SPI1_DR", command)
        self.bare.wait(100 * US)
        self.bare.write("GPIOB_BSRR", 1 << 6)
        self.assertTrue(self.bare.read("SPI1_SR") & 1)
        self.bare.wait(US)
        return self.bare.read("SPI1_DR")

    def test_an_answer_comes_with_the_next_frame_and_has_an_even_parity(self):
        self.encoder.angle = 1
        self.exchange(0xFFFF)
        self.encoder.angle = 3
        self.assertEqual(self.exchange(0xFFFF), 1 | 1 << 15)
        self.assertEqual(self.exchange(0xFFFF), 3)

    def test_a_wrong_command_sets_the_error_flag_until_the_errors_are_read(self):
        self.exchange(0x7FFF)
        self.assertTrue(self.exchange(0xFFFF) & 1 << 14)
        self.assertTrue(self.exchange(0x4001) & 1 << 14)
        self.assertEqual(self.exchange(0xFFFF), 1 | 1 << 15)
        self.assertFalse(self.exchange(0xFFFF) & 1 << 14)

    def test_a_select_that_is_too_short_is_found(self):
        with self.assertRaisesRegex(WrongAccess, "too early"):
            self.exchange(0xFFFF, low=US // 4)
        self.setUp()
        self.bare.write("GPIOB_BSRR", 1 << 22)
        self.bare.wait(US)
        self.bare.write("GPIOB_BSRR", 1 << 6)
        self.bare.wait(US // 4)
        with self.assertRaisesRegex(WrongAccess, "is high for"):
            self.bare.write("GPIOB_BSRR", 1 << 22)


class Crystal(unittest.TestCase):
    """RM0440 7.2: HSE clock, PLL, clock security system."""

    def counts(self, crystal_hz):
        """Of the internal oscillator, in 256 periods of the crystal."""
        bare = Bare(OF_ESC1, crystal_hz=crystal_hz)
        bare.start_crystal()
        for name, value in (("TISEL", 3), ("CCMR1", 0xD), ("CCER", 1), ("CR1", 1)):
            bare.write(f"TIM16_{name}", value)
        found = []
        while len(found) < 9:
            bare.wait_for("TIM16_SR", 2)
            found.append(bare.read("TIM16_CCR1"))
        return [after - before & 0xFFFF for before, after in zip(found, found[1:])]

    def test_its_frequency_is_measured_against_the_internal_oscillator(self):
        self.assertEqual(set(self.counts(8e6)), {512})
        self.assertEqual(sum(self.counts(24e6)[:3]), 512)

    def test_a_missing_one_never_becomes_ready(self):
        bare = Bare(OF_ESC1, crystal_hz=0)
        bare.write("RCC_CR", bare.read("RCC_CR") | digital.HSEON)
        bare.wait(digital.cycles(0.1))
        self.assertFalse(bare.read("RCC_CR") & digital.HSERDY)

    def test_the_clock_follows_the_divider_and_another_crystal_is_found(self):
        for hal, divider, works in ((OF_ESC1, 2, True), (OF_ESC1, 6, False), (WITH_ENABLES, 6, True)):
            bare = Bare(hal)
            if works:
                bare.run_on_crystal(divider)
                self.assertTrue(bare.chip.power.runs_at_full_speed())
            else:
                self.assertRaisesRegex(WrongAccess, "the PLL|the clock is", bare.run_on_crystal, divider)

    def failed(self):
        bare = Bare(OF_ESC1)
        bare.run_on_crystal(2)
        bare.write("RCC_CR", bare.read("RCC_CR") | digital.CSSON)
        bare.write("TIM1_AF1", 0)
        bare.write("TIM1_CCER", 0x555)
        bare.write("TIM1_BDTR", BKE | BKP | MOE)
        bare.chip.power.stop_crystal()
        bare.wait(digital.CRYSTAL_WATCH)
        return bare

    def test_one_that_dies_opens_the_gates_and_leaves_the_internal_oscillator(self):
        bare = self.failed()
        self.assertFalse(bare.chip.timer.gates_on())
        self.assertTrue(bare.read("TIM1_SR") & 1 << 13)
        self.assertEqual(bare.read("RCC_CFGR") & 0xF, 5)
        self.assertEqual(bare.read("RCC_CR") & (digital.CRYSTAL_BITS | digital.PLL_BITS), 0)
        self.assertEqual(bare.chip.clock.cycle, round(170 / 16))

    def test_its_nmi_stays_until_the_flag_is_cleared(self):
        bare = self.failed()
        self.assertEqual(bare.chip.system.take(0), 2)
        self.assertEqual(bare.chip.system.first(0), 2)
        bare.write("RCC_CICR", digital.CSSF)
        self.assertIsNone(bare.chip.system.first(0))

    def test_behind_that_the_internal_oscillator_gives_full_speed_again(self):
        bare = self.failed()
        bare.start_pll(digital.FROM_OSCILLATOR, 4)
        self.assertTrue(bare.chip.power.runs_at_full_speed())
        self.assertEqual(bare.chip.clock.cycle, 1)

    def test_nobody_may_run_on_one_that_is_not_watched_or_not_seen_to_swing(self):
        bare = Bare(OF_ESC1)
        bare.run_on_crystal(2)
        self.assertRaisesRegex(WrongAccess, "nobody watches it", bare.chip.power.stop_crystal)
        bare = Bare(OF_ESC1)
        bare.raise_power()
        self.assertRaisesRegex(WrongAccess, "not seen to be ready", bare.start_pll, digital.FROM_CRYSTAL, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv)
