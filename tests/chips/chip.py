# SPDX-License-Identifier: MIT
"""Facts of a chip by the names that the reference manual uses.

The facts (tests/chips/CHIP.json, made by tools/chips/facts.py) have the names of the crate stm32-metapac: arrays count from
0, and some names are the crate's own. names.toml translates them. A path is PERIPHERAL.REGISTER.FIELD in the crate's names,
as TIM1.CCER.CCE[0]; where all peripherals of a kind are meant, KIND.REGISTER.FIELD, as TIM.CCER.CCE[0].
"""

import json
import re
import tomllib
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
KIND = re.compile(r"(GPIO)[A-G]|([A-Z]+)\d*")
ELEMENT = re.compile(r"(.*)\[(\d+)\]")
ENABLES = re.compile(r"RCC\.A[HP]B\d?ENR\d?\.")


class WrongTable(Exception):
    """names.toml says something that the facts do not bear out."""


@dataclass(frozen=True)
class Fact:
    """One value of the chip. what: address, offset, mask, enable, shift, interrupt, memory or value."""

    what: str
    value: int
    path: str


@dataclass
class Register:
    """One register of one peripheral. `mask`: all bits that the crate knows."""

    peripheral: str
    key: str
    address: int
    offset: int
    fields: dict
    mask: int

    @property
    def path(self):
        return f"{self.peripheral}.{self.key}"


def lowest_bit(mask):
    return (mask & -mask).bit_length() - 1


def placed(value, mask):
    """The value in the bits of the mask, which need not lie side by side."""
    found = 0
    while value and mask:
        lowest = mask & -mask
        found |= lowest if value & 1 else 0
        value, mask = value >> 1, mask & ~lowest
    return found


class Names:
    """names.toml, and which of its rows were of use."""

    def __init__(self, text):
        content = tomllib.loads(text)
        self.peripherals = content["peripherals"]  # the manual's name → the crate's
        self.kinds = content["kinds"]              # peripheral → kind
        self.items = content["names"]              # path of an array or a name of the crate's own → the manual's
        self.values = content["values"]            # macro → paths whose sum it is
        self.enables = content["enables"]          # peripheral or kind → RCC register and field that the crate lacks
        self.errors = content["crate_errors"]      # path → what the crate and the manual say
        self.used = set()

    def kind(self, peripheral):
        match = KIND.fullmatch(peripheral)
        return self.kinds.get(peripheral, match and (match[1] or match[2]))

    def manual(self, prefix, key):
        """The manual's name of a register (prefix: its kind) or of a field (prefix: KIND.REGISTER)."""
        element = ELEMENT.fullmatch(key)
        row = f"{prefix}.{element[1] if element else key}"
        if row not in self.items:
            return key
        self.used.add(row)
        index, pattern = int(element[2]) if element else 0, self.items[row]
        if isinstance(pattern, list):
            return pattern[index]
        return pattern.replace("{0}", str(index)).replace("{1}", str(index + 1))

    def unused(self):
        """Rows that name nothing of any chip that was read with this table."""
        return sorted({*self.items, *self.errors} - self.used)


class Chip:
    """The facts of one chip. `named`: a name as a header of registers has it → its facts."""

    def __init__(self, facts, names):
        self.facts, self.names = facts, names
        self.name = facts["chip"]
        self.pins = facts["pins"]
        self.interrupts = facts["interrupts"]
        self.registers = [register for name in facts["peripherals"] for register in self._registers(name)]
        self.at = defaultdict(list)
        self.named = defaultdict(list)
        self.by_path = defaultdict(list)
        for name, peripheral in facts["peripherals"].items():
            self._add(self._manual_peripheral(name), Fact("address", int(peripheral["base"], 16), name))
        for register in self.registers:
            self.at[register.address].append(register)
            self._name(register)
        for name, number in self.interrupts.items():
            self._add(f"NVIC_{name}", Fact("interrupt", number, name))
        for choice in facts["memories"].values():
            for name, (_, address, _, _) in choice.items():
                self.by_path[f"memories.{name}"].append(Fact("memory", int(address, 16), name))

    def _add(self, name, fact):
        if fact not in self.named[name]:
            self.named[name].append(fact)

    def _manual_peripheral(self, name):
        return next((manual for manual, crate in self.names.peripherals.items() if crate == name), name)

    def _registers(self, name):
        peripheral = self.facts["peripherals"][name]
        kind = self.names.kind(name)
        for key, (offset, bits, fields) in self.facts["registers"].get(peripheral.get("registers"), {}).items():
            masks = {field: self._corrected(kind, key, field, int(mask, 16)) for field, mask in fields.items()}
            whole = (1 << bits) - 1 if not masks else 0
            for mask in masks.values():
                whole |= mask
            offset = int(offset, 16)
            yield Register(name, key, int(peripheral["base"], 16) + offset, offset, masks, whole)

    def _corrected(self, kind, key, field, mask):
        """The crate has errors, too; names.toml has those that matter here."""
        path = f"{kind}.{key}.{field}"
        error = self.names.errors.get(path)
        if error is None:
            return mask
        self.names.used.add(path)
        if mask != int(error["crate"], 16):
            raise WrongTable(f"crate_errors: {path}: the crate has {mask:#x}, and not {error['crate']}")
        return int(error["manual"], 16)

    def _name(self, register):
        """By its peripheral's name, and by that of the kind, where the offset alone counts."""
        peripheral, kind = register.peripheral, self.names.kind(register.peripheral)
        key = self.names.manual(kind, register.key)
        prefixes = [(self._manual_peripheral(peripheral), Fact("address", register.address, register.path))]
        if kind != prefixes[0][0]:
            prefixes.append((kind, Fact("offset", register.offset, register.path)))
        self.by_path[f"{kind}.{register.key}"].append(Fact("offset", register.offset, register.path))
        for prefix, fact in prefixes:
            self._add(f"{prefix}_{key}", fact)
        for field, mask in register.fields.items():
            path = f"{register.path}.{field}"
            fact = Fact("enable" if ENABLES.match(path) else "mask", mask, path)
            self.by_path[path].append(fact)
            if kind != peripheral:
                self.by_path[f"{kind}.{register.key}.{field}"].append(fact)
            manual = self.names.manual(f"{kind}.{register.key.split('[')[0]}", field)
            for prefix, _ in prefixes:
                self._name_field(f"{prefix}_{key}", manual, fact)

    def _name_field(self, register, field, fact):
        self._add(f"{register}_{field}", fact)
        self._add(f"{register}_{field}_SHIFT", Fact("shift", lowest_bit(fact.value), fact.path))
        if fact.what == "enable":
            self._add(f"{register}_{field.removesuffix('EN')}", fact)

    def enable(self, peripheral):
        """(register of RCC, mask) of the clock of a peripheral, or None."""
        given = self.facts["peripherals"][peripheral].get("enable")
        row = next((row for row in (peripheral, self.names.kind(peripheral)) if row in self.names.enables), None)
        if row is not None:
            self.names.used.add(row)
            if given is not None:
                raise WrongTable(f"enables: {row}: the crate has it")
            given = self.names.enables[row]
        if given is None:
            return None
        return given.split(".")[0], self.by_path[f"RCC.{given}"][0].value

    def value(self, part):
        """All facts of "KIND.REGISTER.FIELD", whose value is the field's mask, of "KIND.REGISTER.FIELD=CODE", or of
        "memories.NAME". [] if the chip has none of them."""
        path, _, code = part.partition("=")
        facts = self.by_path.get(path, [])
        if not code:
            return facts
        return [Fact("value", placed(self._code(fact.path, code), fact.value), f"{fact.path}={code}") for fact in facts]

    def _code(self, path, code):
        """A name of the crate's for a value of a field; TRIGGER:SOURCE for a number of EXTSEL or JEXTSEL; REQUEST:PERIPHERAL.SIGNAL
        for one of the DMA's multiplexer."""
        peripheral, _, rest = path.partition(".")
        register, _, field = rest.rpartition(".")
        if code.startswith("REQUEST:"):
            source, _, signal = code.removeprefix("REQUEST:").partition(".")
            return self._request(source, signal)
        if code.startswith("TRIGGER:"):
            return self._trigger(peripheral, field, code.removeprefix("TRIGGER:"))
        kind = self.facts["peripherals"][peripheral]["registers"]
        codes = self.facts["codes"][kind].get(f"{register.split('[')[0]}.{field.split('[')[0]}", {})
        if code not in codes:
            raise WrongTable(f"values: {path}={code}: the crate's codes are: {', '.join(codes) or 'none'}")
        return codes[code]

    def _request(self, source, signal):
        requests = self.facts["peripherals"].get(source, {}).get("requests", {})
        if signal not in requests:
            raise WrongTable(f"values: {source} has no request {signal}")
        return requests[signal]

    def _trigger(self, peripheral, field, source):
        name = "ADC_JEXT_TRG" if field == "JEXTSEL" else "ADC_EXT_TRG"
        for signal, at in self.facts["peripherals"][peripheral]["triggers"].items():
            if at == source and signal.startswith(name):
                return int(signal.removeprefix(name))
        raise WrongTable(f"values: {peripheral} has no trigger {source}")

    def explained(self, name):
        """What the facts say of a header's macro, by its name alone."""
        if name in self.names.values:
            return self._sums(name)
        return self.named.get(name, [])

    def _sums(self, name):
        """A row of [values]: the sum of its parts, each of which may be a fact of several peripherals."""
        row = self.names.values[name]
        parts = [row] if isinstance(row, str) else row
        found = [self.value(part) for part in parts]
        if not all(found):
            return []
        for part, facts in zip(parts, found):
            if len({fact.value for fact in facts}) > 1:
                raise WrongTable(f"values: {name}: {part} differs: {', '.join(fact.path for fact in facts)}")
        if len(found) == 1:
            return found[0]
        return [Fact("value", sum(facts[0].value for facts in found), " + ".join(parts))]

    def field_of(self, name):
        """The longest field's name with which a macro's name begins: its facts."""
        words = name.split("_")
        for length in range(len(words) - 1, 1, -1):
            facts = [fact for fact in self.named.get("_".join(words[:length]), []) if fact.what in ("mask", "enable")]
            if facts:
                return facts
        return []


def read(folder=HERE, names=None):
    """All chips of a folder."""
    names = names or Names((HERE / "names.toml").read_text(encoding="utf-8"))
    return [Chip(json.loads(path.read_text(encoding="utf-8")), names) for path in sorted(folder.glob("stm32*.json"))]
