# SPDX-License-Identifier: MIT
"""target.loop.registers: what the chip's registers hold once the image has booted, each bit by the manual.

test_registers.py IMAGE BOARD CLOCK [TEST...], as scenario.py. The values are written down here a second time, from RM0440, the data sheet
and the board file: a bit that the image forgets, and that no behaviour of the models shows, is missing here.
"""

import sys
import unittest

from rig import CALIBRATION_TICKS, HAL, STAGE, address_of, make

CLOCK_HZ = 170e6
CRYSTAL_HZ = HAL.get("crystal_hz", 0)
HALF_PERIOD = round(CLOCK_HZ / STAGE["pwm_frequency_hz"] / 2)

# Pins by number, two bits each.
ALTERNATE, OUTPUT, ANALOG = 2, 1, 3
UP, DOWN = 1, 2
INPUT = 0
GATES = {"A": (8, 9, 10, 12), "B": (15,), "C": (13,)}
# The board as it is sold has inputs and a connector for a sensor of the shaft; that of the tests has none.
HAS_INPUTS = "pulse_pin" in HAL

# Written to make something happen, or by each tick; what they do is tested as behaviour.
ACTIONS = {"GPIOC_BSRR", "IWDG_KR", "SYSTEM_SYST_CVR", "RCC_CSR", "TIM1_EGR", "TIM1_SR", "TIM1_CCR1", "TIM1_CCR2",
           "TIM1_CCR3", "TIM2_EGR", "TIM16_SR", "CRC_DR", "DMA1_CNDTR1", "DMA1_CNDTR2", "ADC1_ISR", "ADC2_ISR", "USART2_TDR", *(f"TAMP_BKP{word}R" for word in range(8))}


def placed(reset, width, fields):
    """The register with the fields {place: value} of so many bits each."""
    for place, value in fields.items():
        mask = (1 << width) - 1 << width * place
        reset = reset & ~mask | value << width * place
    return reset


def dead_time_code():
    """RM0440 28.6.20, DTG: the shortest of all 256 that is long enough."""
    def ticks(code):
        if code < 0x80:
            return code
        if code < 0xC0:
            return (64 + (code & 0x3F)) * 2
        return (32 + (code & 0x1F)) * (8 if code < 0xE0 else 16)

    wanted = STAGE["dead_time_s"] * CLOCK_HZ * (1 - 1e-9)
    return min((code for code in range(256) if ticks(code) >= wanted), key=lambda code: (ticks(code), code))


def sampling_code():
    """RM0440 21.7.6: 2.5, 6.5, 12.5, 24.5, 47.5 cycles of a quarter of the clock."""
    cycles = HAL["adc_sampling_ns"] * 1e-9 * CLOCK_HZ / 4
    return next(code for code, long in enumerate((2.5, 6.5, 12.5, 24.5, 47.5)) if long >= cycles)


def trip_count():
    """Counts of the DAC, of 4096: the shunt's voltage and the bias before the amplifier."""
    sign = 1 if HAL["break_polarity"] == "active_high" else -1
    rise = STAGE["trip_a"] * HAL["shunt_ohm"] * abs(HAL["amplifier_gain"])
    return round((HAL["amplifier_zero_v"] + sign * rise) / HAL["pga_gain"] / HAL["adc_reference_v"] * 4096)


def pins():
    analog = {"A": (0, 1, 2, 3, 5, 6, 7), "B": (0, 1, 2, 14) + ((12,) if HAS_INPUTS else ()), "C": ()}
    serial = {"A": (), "B": (3, 4), "C": ()}
    counted = {"A": (15,), "B": (6, 7, 8), "C": ()} if HAS_INPUTS else dict.fromkeys("ABC", ())
    reset = {"A": (0xABFFFFFF, 0x64000000, 0x0C000000), "B": (0xFFFFFEBF, 0x100, 0), "C": (0xFFFFFFFF, 0, 0)}
    for port in "ABC":
        mode, pull, speed = reset[port]
        used = GATES[port] + serial[port] + counted[port]
        led = {6: OUTPUT} | ({10: INPUT} if HAS_INPUTS else {}) if port == "C" else {}
        yield f"GPIO{port}_MODER", placed(mode, 2, dict.fromkeys(used, ALTERNATE) | dict.fromkeys(analog[port], ANALOG) | led)
        pulls = dict.fromkeys(GATES[port], DOWN) | ({3: 0, 4: UP} if port == "B" else {})
        if HAS_INPUTS:
            pulls |= {"A": {15: DOWN}, "B": dict.fromkeys((6, 7, 8), UP), "C": {10: UP}}[port]
        yield f"GPIO{port}_PUPDR", placed(pull, 2, pulls)
        yield f"GPIO{port}_OSPEEDR", placed(speed, 2, dict.fromkeys(used, 2))


def inputs():
    """Pulses of PA15 by both of the first channels of timer 2; the time since the last Hall edge by timer 4."""
    ring = 1 | 1 << 5 | 1 << 7 | 2 << 8 | 2 << 10    # enabled, circular, the next word of memory; words
    filtered = 1 | 5 << 4                            # its own input, 8 samples at half the clock
    return {
        "DMAMUX1_C0CR": 56,                          # captures of channels 1 and 2
        "DMAMUX1_C1CR": 57,
        "DMA1_CCR1": ring,
        "DMA1_CCR2": ring,
        "DMA1_CPAR1": 0x40000034,
        "DMA1_CPAR2": 0x40000038,
        "DMA1_CMAR1": address_of("pulses_rises"),
        "DMA1_CMAR2": address_of("pulses_falls"),
        "TIM2_PSC": 16,                              # 10 MHz
        "TIM2_ARR": 0xFFFFFFFF,
        "TIM2_CCMR1": 1 | 7 << 4 | 2 << 8,           # both look at input 1, 8 samples at a quarter of the clock
        "TIM2_CCER": 1 | 1 << 4 | 1 << 5,            # rising, falling
        "TIM2_DIER": 1 << 9 | 1 << 10,
        "TIM2_CR1": 1,
        "TIM4_CR2": 1 << 7,                          # input 1 is the exclusive or of three channels
        "TIM4_CCMR1": filtered,
        "TIM4_SMCR": 4 << 4 | 4,                     # each edge of it sets the counter to 0
        "TIM4_PSC": 0,
        "TIM4_ARR": 0xFFFF,
        "TIM4_CR1": 1,
    }


def expected():
    amplifier = 1 | 2 << 5 | 1 << 7 | 8 << 14 | (HAL["pga_gain"].bit_length() - 2) << 14
    comparator = 1 | 4 << 4 | 1 << 16 | 1 << 31      # on, against DAC3, 10 mV of hysteresis, locked
    sampling, slow = sampling_code(), 4
    channels = placed(0, 3, {1: slow, 3: sampling, 5: slow})
    upper = placed(0, 3, {8: sampling} | ({1: slow} if HAS_INPUTS else {}))
    sequence = 1 | 8 << 2 | 1 << 7 | 3 << 9          # two, on the rising edge of TIM1's TRGO2, the first is channel 3
    inverted = 0 if HAL["break_polarity"] == "active_high" else 1 << 10 | 1 << 11 | 1 << 13
    return dict(pins()) | (inputs() if HAS_INPUTS else {}) | {
        "SYSTEM_SCB_VTOR": 0x08000000,
        # backup registers, USART2, PWR; timers 2 and 4
        "RCC_APB1ENR1": 1 << 10 | 1 << 17 | 1 << 28 | (1 | 1 << 2 if HAS_INPUTS else 0),
        "RCC_APB2ENR": 1 << 0 | 1 << 11 | 1 << 17,   # SYSCFG, TIM1, TIM16
        "RCC_AHB1ENR": 1 << 8 | 1 << 12 | (1 | 1 << 2 if HAS_INPUTS else 0), # flash as after reset, CRC unit; DMA
        "CRC_CR": 7 << 5,                            # words and result with the lowest bit first
        "RCC_AHB2ENR": 7 | 1 << 13 | 1 << 18,        # ports, converters, DAC3
        "RCC_CR": 1 << 8 | 1 << 10 | 1 << 24 | 1 << 25 | (1 << 16 | 1 << 17 | 1 << 19 if CRYSTAL_HZ else 0),
        "RCC_PLLCFGR": (3 if CRYSTAL_HZ else 2) | round((CRYSTAL_HZ or 16e6) / 4e6) - 1 << 4 | 85 << 8 | 1 << 24,
        "RCC_CFGR": 0xF,
        "PWR_CR1": 0x200 | 1 << 8,                   # range 1; backup registers that can be written
        "PWR_CR5": 0,                                # boost
        "PWR_CR3": 0x8000 | 1 << 14,                 # PB4 without the pull-down of a dead battery
        "FLASH_ACR": 0x40000 | 4 | 7 << 8,
        "GPIOA_AFRH": placed(0, 4, {0: 6, 1: 6, 2: 6, 4: 6} | ({7: 1} if HAS_INPUTS else {})),
        "GPIOB_AFRL": placed(0, 4, {3: 7, 4: 7} | ({6: 2, 7: 2} if HAS_INPUTS else {})),
        "GPIOB_AFRH": placed(0, 4, {7: 4} | ({0: 2} if HAS_INPUTS else {})),
        "GPIOC_AFRH": placed(0, 4, {5: 4}),
        "USART2_BRR": round(CLOCK_HZ / STAGE["baud"]),
        "USART2_CR1": 1 | 1 << 2 | 1 << 3 | 1 << 29,
        "SYSTEM_SYST_RVR": 3 * HALF_PERIOD - 1,
        "SYSTEM_SYST_CSR": 7,
        "SYSTEM_SCB_SHPR3": 0,                       # the tick guard above the tick
        "SYSTEM_NVIC_IPR4": 1 << 20,
        "SYSTEM_NVIC_ISER0": 1 << 18,
        "DAC3_MCR": 3 | 3 << 16 | 2 << 14,
        "DAC3_DHR12R1": trip_count(),
        "DAC3_DHR12R2": trip_count(),
        "DAC3_CR": 1 | 1 << 16,
        "COMP_1_CSR": comparator,
        "COMP_2_CSR": comparator,
        "COMP_4_CSR": comparator,
        "OPAMP_1_CSR": amplifier,
        "OPAMP_2_CSR": amplifier,
        "OPAMP_3_CSR": amplifier | 1 << 8,           # inside, to ADC2
        "TIM1_CR1": 1 | 1 << 5 | 1 << 7,
        "TIM1_CR2": 2 << 20,
        "TIM1_CCMR1": 0x6868,
        "TIM1_CCMR2": 0x68,
        "TIM1_CCER": 0x555,
        "TIM1_PSC": 0,
        "TIM1_ARR": HALF_PERIOD,
        "TIM1_RCR": 1,
        "TIM1_AF1": 1 << 1 | 1 << 2 | 1 << 4 | inverted,
        # Locked; idle and run level driven; break on, active high, through 6 samples each 4 clocks apart; gates open.
        "TIM1_BDTR": dead_time_code() | 1 << 8 | 1 << 10 | 1 << 11 | 1 << 12 | 1 << 13 | 6 << 16,
        "SYSCFG_CFGR2": 7,                           # lockup of the core, parity of the RAM and supply open the gates
        "PWR_CR2": 1 | 5 << 1,                       # the supply, against 2.8 V
        "TIM16_CR1": 1,
        "TIM16_TISEL": 6,                            # the watchdog's oscillator
        "TIM16_CCMR1": 1 | 3 << 2,                   # captured at each eighth edge
        "TIM16_CCER": 1,
        "ADC12_CCR": 3 << 16,
        "ADC1_CR": 1 | 1 << 3 | 1 << 28,
        "ADC2_CR": 1 | 1 << 3 | 1 << 28,
        "ADC1_CFGR": 1 << 31 | 1 << 12,
        "ADC2_CFGR": 1 << 31 | 1 << 12,
        "ADC1_SMPR1": channels,
        "ADC2_SMPR1": channels,
        "ADC1_SMPR2": upper,
        "ADC2_SMPR2": upper,
        "ADC1_SQR1": (11 if HAS_INPUTS else 5) << 6, # what was converted last: the throttle, or the temperature
        "ADC2_SQR1": 3 << 6,
        "ADC1_JSQR": sequence | 1 << 15,             # then the bus
        "ADC2_JSQR": sequence | 18 << 15,            # then phase c
        "ADC1_IER": 1 << 6,
        "IWDG_PR": 0,
        "IWDG_RLR": 7,                               # 8 of 125 µs
        "DBGMCU_APB1FZR1": 1 << 12,                  # the watchdog stops with a halted core,
        "DBGMCU_APB2FZ": 1 << 11,                    # and the gates open
    }


class Registers(unittest.TestCase):
    def setUp(self):
        self.made = make()
        blocks = self.made.chip.blocks
        self.registers = {f"{block.name}_{key}": register for block in blocks
                          for key, register in block.by_address.values()}
        self.names = {address: f"{block.name}_{key}" for block in blocks
                      for address, (key, _) in block.by_address.items()}

    def start(self):
        self.made.boot()
        self.made.tick(CALIBRATION_TICKS)

    def test_hold_what_the_manual_asks_for(self):
        self.start()
        for name, value in expected().items():
            with self.subTest(name):
                self.assertEqual(f"{self.registers[name].value:#010x}", f"{value:#010x}")

    def test_of_those_that_the_image_writes_none_is_missing_here(self):
        written, write = set(), self.made.core.bus.write

        def note(address, size, value):
            written.add(self.names[address])
            return write(address, size, value)

        self.made.core.bus.write = note
        self.start()
        self.assertEqual(written - ACTIONS, set(expected()))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
