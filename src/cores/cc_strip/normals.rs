//! Normals of the rows of a column: cross products of vectors, and their sums around each vertex.
//!
//! ```text
//!   vectors    1 clock, for tangents 2    differences of points (see `vectors`), one unit an axis
//!   products   1 clock                    six for each cross product
//!   sums       1 clock                    of the faces above and below a row; at an end of the fan outside
//!   unit       7 clocks                   where unit vectors are wanted (see `unit`)
//! ```
//!
//! A face normal is the cross product of the face's diagonals, twice its vector area, and is made once for the
//! two rows that share it. No product is rounded, so neighbouring strips agree on the normals that they share.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::fan::End;
use super::finish::{AXES, Kind, Parameters, stage};
use super::view::View;
use super::view_ports::connected;
use super::{unit, vectors};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Sum, Word};

/// Clocks from the view to the sums.
fn latency(p: Parameters) -> u32 {
    vectors::latency(p) + 2
}

/// A vector of three signals.
type Vector = [Signal; 3];

/// The normal of each row, registered, and the clocks that it takes.
pub(super) fn normals(
    m: &Builder,
    p: Parameters,
    views: [&View; 3],
    advance: &Signal,
) -> Result<(Vec<Vector>, u32)> {
    let (Some(wanted), Some(word)) = (p.normals, p.normal_word()) else { return Ok((vec![], 0)) };
    let crossed = cross_products(m, p, views, advance)?;
    // Which row is the bottom one, beside the cross products.
    let is_bottom = p.bottoms().map(|k| {
        let wait = |bit: Signal, clock| stage(m, advance, format!("is_bottom_{k}_{clock}"), &bit);
        (k, (1..latency(p)).fold(views[0].is_bottom[k].clone(), wait))
    });
    let is_bottom: BTreeMap<usize, Signal> = is_bottom.collect();
    let sums = match wanted.kind {
        Kind::Faces => of_faces(m, p, &crossed, &is_bottom),
        Kind::Limit => of_surface(m, p, &crossed, &is_bottom),
    };
    let keep = |(row, normal): (usize, Vector)| {
        [0, 1, 2].map(|axis| {
            let register = m.register(format!("normal_{row}_{}", AXES[axis]), word);
            m.on(advance, &register, &normal[axis]);
            register
        })
    };
    let normals: Vec<Vector> = sums.into_iter().enumerate().map(keep).collect();
    let Some(bits) = wanted.unit else { return Ok((normals, latency(p))) };
    let unit = unit::build(word, bits)?;
    let shorten = |(row, normal): (usize, &Vector)| {
        let placed = m.instance(
            &format!("unit_{row}"),
            &unit,
            &[("x", &normal[0]), ("y", &normal[1]), ("z", &normal[2]), ("advance", advance)],
        );
        AXES.map(|axis| placed.out(&format!("unit_{axis}")))
    };
    Ok((normals.iter().enumerate().map(shorten).collect(), latency(p) + unit::LATENCY))
}

/// The cross product of each pair of vectors by name.
fn cross_products(
    m: &Builder,
    p: Parameters,
    views: [&View; 3],
    advance: &Signal,
) -> Result<BTreeMap<String, Vector>> {
    let (rounding, differences) = (vectors::points(p)?, vectors::build(p)?);
    let names = super::view_ports::names(p);
    let mut placed = vec![];
    for (view, axis) in views.iter().zip(AXES) {
        let inputs = connected(m, p, &names, view, p.word);
        let given = |unit: &Rc<Module>, from: &[(String, Signal)]| -> Vec<(String, Signal)> {
            from.iter().filter(|(name, _)| unit.input(name).is_some()).cloned().collect()
        };
        let points = place(m, &format!("points_{axis}"), &rounding, &given(&rounding, &inputs));
        let mut inputs: Vec<(String, Signal)> = inputs
            .into_iter()
            .map(|(name, signal)| match rounding.input(&name) {
                Some(_) => (name.clone(), points(&format!("point_{name}"))),
                None => (name, signal),
            })
            .collect();
        inputs.push(("advance".into(), advance.clone()));
        placed.push(place(m, &format!("vectors_{axis}"), &differences, &given(&differences, &inputs)));
    }
    let mut units: BTreeMap<&str, Rc<Module>> = BTreeMap::new();
    let mut crossed = BTreeMap::new();
    for (name, sort, word) in vectors::names(p) {
        if !units.contains_key(sort) {
            units.insert(sort, cross(&format!("cross_{sort}"), word)?);
        }
        let mut inputs = vec![("advance".to_string(), advance.clone())];
        for (axis, vectors) in AXES.iter().zip(&placed) {
            inputs.extend(["a", "b"].map(|v| (format!("{v}_{axis}"), vectors(&format!("{name}_{v}")))));
        }
        let out = place(m, &format!("cross_{name}"), &units[sort], &inputs);
        crossed.insert(name, AXES.map(out));
    }
    Ok(crossed)
}

/// An instance with inputs by owned names; what it returns gives the outputs.
fn place(
    m: &Builder,
    name: &str,
    unit: &Rc<Module>,
    inputs: &[(String, Signal)],
) -> impl Fn(&str) -> Signal + use<> {
    let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
    let placed = m.instance(name, unit, &inputs);
    move |output| placed.out(output)
}

/// a x b one clock later. Inputs: `a_x` .. `b_z` in `word`, and `advance`; outputs `x`, `y`, `z`.
pub(super) fn cross(name: &str, word: Word) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    m.purpose("The cross product a x b: six products, registered, and three differences.");
    let [a, b] = ["a", "b"].map(|v| AXES.map(|axis| m.input(format!("{v}_{axis}"), word)));
    let advance = m.input("advance", Word::bit());
    for (x, axis) in AXES.iter().enumerate() {
        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
        let product = |left: usize, right: usize| {
            let name = format!("a_{}_b_{}", AXES[left], AXES[right]);
            let product = m.wire(name.clone(), m.product(&a[left], &b[right]));
            stage(&m, &advance, format!("{name}_kept"), &product)
        };
        m.output(*axis, m.wire(*axis, &product(y, z) - &product(z, y)));
    }
    m.finish()
}

fn total(m: &Builder, name: &str, parts: &[&Vector]) -> Vector {
    [0, 1, 2].map(|axis| {
        let sum = Sum::weighted(parts.iter().map(|part| (1, &part[axis])));
        m.wire(format!("{name}_{}", AXES[axis]), sum)
    })
}

fn chosen(m: &Builder, condition: &Signal, on_true: &Vector, on_false: &Vector) -> Vector {
    [0, 1, 2].map(|axis| m.select(condition, &on_true[axis], &on_false[axis]))
}

/// The faces above and below each row.
fn of_faces(
    m: &Builder,
    p: Parameters,
    crossed: &BTreeMap<String, Vector>,
    is_bottom: &BTreeMap<usize, Signal>,
) -> Vec<Vector> {
    let last = p.rows() - 1;
    let pair = |k: usize| {
        let sides = ["left", "right"].map(|side| &crossed[&vectors::face(side, k)]);
        total(m, &format!("faces_{k}"), &sides)
    };
    let pairs: Vec<Vector> = (0..last).map(pair).collect();
    let [top, bottom] = End::BOTH.map(|end| {
        let faces: Vec<&Vector> = (1..p.max_valence - 1).map(|i| &crossed[&vectors::fan(end, i)]).collect();
        total(m, &format!("{}_faces", end.name()), &faces)
    });
    let row = |k: usize| {
        let above = if k == 0 { &top } else { &pairs[k - 1] };
        let below = match is_bottom.get(&k) {
            _ if k == last => bottom.clone(),
            Some(is_bottom) => chosen(m, is_bottom, &bottom, &pairs[k]),
            None => pairs[k].clone(),
        };
        total(m, &format!("around_{k}"), &[above, &below])
    };
    (0..=last).map(row).collect()
}

/// The normals of the limit surface.
fn of_surface(
    m: &Builder,
    p: Parameters,
    crossed: &BTreeMap<String, Vector>,
    is_bottom: &BTreeMap<usize, Signal>,
) -> Vec<Vector> {
    let last = p.rows() - 1;
    let [top, bottom] = End::BOTH.map(|end| &crossed[&vectors::end(end)]);
    let row = |k: usize| match is_bottom.get(&k) {
        _ if k == 0 => top.clone(),
        _ if k == last => bottom.clone(),
        Some(is_bottom) => chosen(m, is_bottom, bottom, &crossed[&vectors::row(k)]),
        None => crossed[&vectors::row(k)].clone(),
    };
    (0..=last).map(row).collect()
}
