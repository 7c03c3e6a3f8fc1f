//! The results of several shards as one list: sorted, every point once.

use std::collections::BTreeMap;

use super::point::Point;
use super::record::{Planned, Record};
use crate::error::{Error, Result};

/// Puts lists of results together, in the order of the points. `lists` are file names with their results.
///
/// # Errors
/// A point with two results that differ; a line whose key is not its own.
pub fn merge(lists: Vec<(String, Vec<Record>)>) -> Result<Vec<Record>> {
    let mut merged: BTreeMap<String, (String, Record)> = BTreeMap::new();
    for (file, records) in lists {
        for record in records {
            record.point.point().map_err(|error| error.at(&file))?;
            match merged.get(&record.point.key) {
                Some((other, known)) if *known != record => {
                    let what = format!("two results of the point {}: {}", record.point.key, record.label());
                    return Err(Error::input(what).at(format!("{other} and {file}")).help(
                        "results of different versions do not mix: evaluate the shards with one version",
                    ));
                }
                Some(_) => {}
                None => drop(merged.insert(record.point.key.clone(), (file.clone(), record))),
            }
        }
    }
    let mut records: Vec<Record> = merged.into_values().map(|(_, record)| record).collect();
    sort(&mut records)?;
    Ok(records)
}

/// Brings results into the order of their points, and points that are equal there into that of their keys.
///
/// # Errors
/// A line whose key is not its own.
pub fn sort(records: &mut Vec<Record>) -> Result<()> {
    let mut keyed = vec![];
    for record in records.drain(..) {
        keyed.push((record.point.point()?, record));
    }
    keyed.sort_by_cached_key(|(point, record)| (Point::order(point), record.point.key.clone()));
    records.extend(keyed.into_iter().map(|(_, record)| record));
    Ok(())
}

/// Refuses results that lack a point of the plan.
///
/// # Errors
/// How many are missing, and the first of them.
pub fn complete(records: &[Record], plan: &[Planned]) -> Result<()> {
    let known: std::collections::BTreeSet<&str> = records.iter().map(|r| r.point.key.as_str()).collect();
    let missing: Vec<&Planned> = plan.iter().filter(|point| !known.contains(point.key.as_str())).collect();
    match missing.first() {
        None => Ok(()),
        Some(first) => {
            let what = format!("{} of {} points of the plan are missing", missing.len(), plan.len());
            Err(Error::input(what)
                .at(format!("the first is {}", first.key))
                .help("run the shards that are not finished"))
        }
    }
}
