// SPDX-License-Identifier: MIT
//! Prints facts of one chip as JSON: memories, interrupts, pins, and the peripherals that a drive's binding or the
//! emulator of a board uses. They come from the crate stm32-metapac, which is made from ST's own data. The chip is
//! the one feature that the program is built with. tools/chips/facts.py builds it for each chip and lays the output
//! out for reading.
//!
//! Names are those of the crate, in capitals. Elements of an array carry their index, from 0: `CCR[0]`. Addresses,
//! offsets and masks are hexadecimal text.
//!
//!     memories      {choice: {name: [kind, address, size, size of an erased page or 0]}}; a chip whose flash may be
//!                   one bank or two has two choices
//!     interrupts    {name: number}
//!     pins          {pin: {PERIPHERAL_SIGNAL: alternate function, or null where the pin is analogue}}
//!     peripherals   {name: {base, registers: key of `registers`, and where there are some enable: REGISTER.FIELD of
//!                   RCC, kernel: the clock, or the field of RCC that chooses it, interrupts: {signal: interrupt},
//!                   triggers: {signal: source}, requests: {signal: number at the DMA multiplexer}}}
//!     registers     {kind: {register: [offset, bits, {field: mask}]}}
//!     codes         {kind: {REGISTER.FIELD: {name: value}}}

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use stm32_metapac::metadata::ir::{Array, BitOffset, Block, BlockItemInner, Field, FieldSet, Register, IR};
use stm32_metapac::metadata::{Peripheral, PeripheralRcc, PeripheralRccKernelClock, METADATA};

/// All peripherals whose names are one of these, with at most one letter or digit after it.
const KINDS: &[&str] = &[
    "ADC", "COMP", "CRC", "DAC", "DBGMCU", "FLASH", "GPIO", "IWDG", "LPUART", "OPAMP", "PWR", "RCC", "SYSCFG", "TAMP",
    "USART",
];
/// Of other kinds only these.
#[rustfmt::skip]
const SINGLE: &[&str] = &[
    "ADC12_COMMON", "ADC345_COMMON", "DMA1", "DMAMUX1", "FDCAN1", "SPI1", "SPI2", "SPI3", "TIM1", "TIM2", "TIM3",
    "TIM4", "TIM16", "TIM17", "UART4",
];

type Object = BTreeMap<String, String>;

fn is_used(name: &str) -> bool {
    let is_of = |kind: &&str| name.strip_prefix(kind).is_some_and(|rest| rest.len() <= 1);
    KINDS.iter().any(is_of) || SINGLE.contains(&name)
}

fn object(members: impl IntoIterator<Item = (String, String)>) -> String {
    let members: Object = members.into_iter().collect();
    let texts: Vec<String> = members.iter().map(|(key, value)| format!("{}:{value}", text(key))).collect();
    format!("{{{}}}", texts.join(","))
}

fn list(values: &[String]) -> String {
    format!("[{}]", values.join(","))
}

/// The crate's names are plain ASCII: what Rust shows is JSON, too.
fn text(value: impl Display) -> String {
    format!("{:?}", value.to_string())
}

fn hex(value: u64, digits: usize) -> String {
    format!("\"{value:#0width$x}\"", width = digits + 2)
}

/// The crate writes the name of one block as TIM_ADV and TimAdv.
fn is_same(one: &str, other: &str) -> bool {
    let plain = |name: &str| name.replace('_', "").to_lowercase();
    plain(one) == plain(other)
}

/// The suffix and the distance of each element of an array; of what is no array, that of the one element.
fn elements(array: &Option<Array>) -> Vec<(String, u32)> {
    let offsets: Vec<u32> = match array {
        None => return vec![(String::new(), 0)],
        Some(Array::Regular(regular)) => (0..regular.len).map(|k| k * regular.stride).collect(),
        Some(Array::Cursed(cursed)) => cursed.offsets.to_vec(),
    };
    offsets.iter().enumerate().map(|(k, offset)| (format!("[{k}]"), *offset)).collect()
}

fn mask(field: &Field) -> u64 {
    let run = |first: u32, bits: u32| ((1 << bits) - 1) << first;
    match &field.bit_offset {
        BitOffset::Regular(regular) => run(regular.offset, field.bit_size),
        BitOffset::Cursed(cursed) => cursed.ranges.iter().map(|r| run(*r.start(), r.end() - r.start() + 1)).sum(),
    }
}

/// What is found of one kind of block.
#[derive(Default)]
struct Kind {
    registers: Object,
    codes: Object,
}

impl Kind {
    /// A block that extends another one has the registers of both; its own ones count.
    fn add_block(&mut self, ir: &IR, block: &Block, base: u32, prefix: &str) {
        if let Some(parent) = block.extends.and_then(|name| find_block(ir, name)) {
            self.add_block(ir, parent, base, prefix);
        }
        for item in block.items {
            for (suffix, distance) in elements(&item.array) {
                let name = format!("{prefix}{}{suffix}", item.name.to_uppercase());
                let offset = base + item.byte_offset + distance;
                match &item.inner {
                    BlockItemInner::Block(inner) => {
                        let inner = find_block(ir, inner.block).expect("a block that the crate names");
                        self.add_block(ir, inner, offset, &format!("{name}."));
                    }
                    BlockItemInner::Register(register) => self.add_register(ir, &name, offset, register),
                }
            }
        }
    }

    fn add_register(&mut self, ir: &IR, name: &str, offset: u32, register: &Register) {
        let set = register.fieldset.and_then(|name| find_fieldset(ir, name));
        let fields = set.map_or_else(BTreeMap::new, |set| fields_of(ir, set));
        let masks = fields.values().flat_map(|field| {
            let first = mask(field);
            elements(&field.array).into_iter().map(move |(suffix, distance)| {
                (format!("{}{suffix}", field.name.to_uppercase()), hex(first << distance, 1))
            })
        });
        let shape = [hex(offset.into(), 2), register.bit_size.to_string(), object(masks)];
        self.registers.insert(name.to_string(), list(&shape));
        for field in fields.values() {
            if let Some(codes) = field.enumm.and_then(|name| ir.enums.iter().find(|e| is_same(e.name, name))) {
                let values = codes.variants.iter().map(|code| (code.name.to_string(), code.value.to_string()));
                let plain = name.split('[').next().unwrap_or(name);
                self.codes.insert(format!("{plain}.{}", field.name.to_uppercase()), object(values));
            }
        }
    }
}

fn find_block<'a>(ir: &'a IR, name: &str) -> Option<&'a Block> {
    ir.blocks.iter().find(|block| is_same(block.name, name))
}

fn find_fieldset<'a>(ir: &'a IR, name: &str) -> Option<&'a FieldSet> {
    ir.fieldsets.iter().find(|set| is_same(set.name, name))
}

/// By name; a set that extends another one has the fields of both, and its own ones count.
fn fields_of<'a>(ir: &'a IR, set: &'a FieldSet) -> BTreeMap<&'a str, &'a Field> {
    let parent = set.extends.and_then(|name| find_fieldset(ir, name));
    let mut fields = parent.map_or_else(BTreeMap::new, |parent| fields_of(ir, parent));
    fields.extend(set.fields.iter().map(|field| (field.name, field)));
    fields
}

fn key_of(peripheral: &Peripheral) -> Option<String> {
    peripheral.registers.as_ref().map(|r| format!("{}/{}/{}", r.kind, r.version, r.block))
}

fn clocks(rcc: &PeripheralRcc) -> Object {
    let mut found = Object::new();
    if let Some(enable) = &rcc.enable {
        found.insert("enable".into(), text(format!("{}.{}", enable.register, enable.field)));
    }
    let kernel = match &rcc.kernel_clock {
        PeripheralRccKernelClock::Clock(name) => name.to_string(),
        PeripheralRccKernelClock::Mux(choice) => format!("{}.{}", choice.register, choice.field),
    };
    found.insert("kernel".into(), text(kernel));
    found
}

fn peripheral(of: &Peripheral) -> String {
    let mut members = of.rcc.as_ref().map_or_else(Object::new, clocks);
    members.insert("base".into(), hex(of.address, 8));
    if let Some(key) = key_of(of) {
        members.insert("registers".into(), text(key));
    }
    if !of.interrupts.is_empty() {
        let interrupts = of.interrupts.iter().map(|i| (i.signal.to_string(), text(i.interrupt)));
        members.insert("interrupts".into(), object(interrupts));
    }
    if !of.triggers.is_empty() {
        let triggers = of.triggers.iter().map(|t| (t.signal.to_string(), text(t.source)));
        members.insert("triggers".into(), object(triggers));
    }
    let requests = of.dma_channels.iter().filter_map(|dma| dma.request.map(|r| (dma.signal.to_string(), r.to_string())));
    let requests: Vec<(String, String)> = requests.collect();
    if !requests.is_empty() {
        members.insert("requests".into(), object(requests));
    }
    object(members)
}

fn memories() -> String {
    object(METADATA.memory.iter().enumerate().map(|(choice, regions)| {
        let regions = regions.iter().map(|region| {
            let page = region.settings.as_ref().map_or(0, |settings| settings.erase_size);
            let kind = text(format!("{:?}", region.kind));
            let shape = [kind, hex(region.address.into(), 8), hex(region.size.into(), 1), page.to_string()];
            (region.name.to_string(), list(&shape))
        });
        (choice.to_string(), object(regions))
    }))
}

fn pins(used: &[&Peripheral]) -> String {
    object(METADATA.pins.iter().map(|pin| {
        let signals = used.iter().flat_map(|p| {
            p.pins.iter().filter(|at| at.pin == pin.name).map(move |at| {
                let function = at.af.map_or("null".to_string(), |af| af.to_string());
                (format!("{}_{}", p.name, at.signal), function)
            })
        });
        (pin.name.to_string(), object(signals))
    }))
}

fn main() {
    let used: Vec<&Peripheral> = METADATA.peripherals.iter().filter(|p| is_used(p.name)).collect();
    let (mut registers, mut codes, mut seen) = (Object::new(), Object::new(), BTreeSet::new());
    for p in &used {
        let (Some(key), Some(r)) = (key_of(p), &p.registers) else { continue };
        if seen.insert(key.clone()) {
            let mut kind = Kind::default();
            kind.add_block(r.ir, find_block(r.ir, r.block).expect("a block that the crate names"), 0, "");
            registers.insert(key.clone(), object(kind.registers));
            codes.insert(key, object(kind.codes));
        }
    }
    let interrupts = METADATA.interrupts.iter().map(|i| (i.name.to_string(), i.number.to_string()));
    let facts = [
        ("chip", text(METADATA.name.to_lowercase())),
        ("memories", memories()),
        ("interrupts", object(interrupts)),
        ("pins", pins(&used)),
        ("peripherals", object(used.iter().map(|p| (p.name.to_string(), peripheral(p))))),
        ("registers", object(registers)),
        ("codes", object(codes)),
    ];
    println!("{}", object(facts.map(|(name, value)| (name.to_string(), value))));
}
