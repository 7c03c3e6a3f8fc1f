//! Lists of numbers as the command line has them: `12..24` with both ends, `8,12,16`, or both: `4,8..10`.

use std::str::FromStr;

use crate::error::{Error, Result};

/// The most numbers in one list.
const MOST: usize = 1000;

/// Numbers in ascending order, none twice, at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbers(Vec<u32>);

impl Numbers {
    pub fn values(&self) -> &[u32] {
        &self.0
    }
}

impl From<u32> for Numbers {
    fn from(number: u32) -> Self {
        Numbers(vec![number])
    }
}

impl FromStr for Numbers {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse = |what: String| Error::usage(what).help("write 12, 12..24 (both ends belong) or 8,12,16");
        let number = |part: &str| {
            part.trim().parse::<u32>().map_err(|_| refuse(format!("'{text}' is no list of whole numbers")))
        };
        let mut numbers = vec![];
        for part in text.split(',') {
            let (first, last) = match part.split_once("..") {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(part)?, number(part)?),
            };
            if first > last {
                return Err(refuse(format!("the range {first}..{last} runs backwards")));
            }
            if numbers.len() + (last - first) as usize >= MOST {
                return Err(refuse(format!("'{text}' has more than {MOST} numbers")));
            }
            numbers.extend(first..=last);
        }
        numbers.sort_unstable();
        numbers.dedup();
        Ok(Numbers(numbers))
    }
}

/// Five numbers or ranges, one for each order of differences: `7,10..12,15,18,18`; every combination that does not
/// fall: F0 <= F1 <= ... <= F4.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fractions(Vec<[u32; 5]>);

impl Fractions {
    pub fn values(&self) -> &[[u32; 5]] {
        &self.0
    }
}

impl FromStr for Fractions {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse = |what: String| {
            Error::usage(what).help("write five numbers or ranges, for example 7,10..12,15,18,18")
        };
        let lists = text.split(',').map(Numbers::from_str).collect::<Result<Vec<_>>>()?;
        let lists: [Numbers; 5] =
            lists.try_into().map_err(|_| refuse(format!("'{text}' does not have five orders")))?;
        if lists.iter().map(|list| list.0.len()).product::<usize>() > MOST * MOST {
            return Err(refuse(format!("'{text}' has more than {} combinations", MOST * MOST)));
        }
        let mut all: Vec<Vec<u32>> = vec![vec![]];
        for list in &lists {
            let longer = all.iter().flat_map(|prefix| {
                let least = prefix.last().copied().unwrap_or(0);
                let more = list.0.iter().filter(move |&&bits| bits >= least);
                more.map(|&bits| [prefix.as_slice(), &[bits]].concat())
            });
            all = longer.collect();
        }
        if all.is_empty() {
            return Err(refuse(format!(
                "'{text}' has no combination that does not fall from order to order"
            )));
        }
        // Each list has five numbers: one from each of the five.
        Ok(Fractions(all.into_iter().filter_map(|bits| bits.try_into().ok()).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists_mix() {
        let values = |text: &str| text.parse::<Numbers>().unwrap().0;
        assert_eq!(values("12..15"), [12, 13, 14, 15]);
        assert_eq!(values("16,8,12"), [8, 12, 16]);
        assert_eq!(values("4,4..6,5"), [4, 5, 6]);
        for bad in ["", "a", "5..3", "1..", "..3", "1..5000", "-1", "1.5"] {
            assert_eq!(bad.parse::<Numbers>().unwrap_err().exit_status(), 2, "{bad}");
        }
    }

    #[test]
    fn orders_never_fall() {
        let values = |text: &str| text.parse::<Fractions>().unwrap().0;
        assert_eq!(values("7,11,15,18,18"), [[7, 11, 15, 18, 18]]);
        assert_eq!(values("1..2,1..2,2,2,3").len(), 3);
        for bad in ["1,2,3", "5,4,5,5,5", "1..999,1..999,1..999,1,1"] {
            assert!(bad.parse::<Fractions>().is_err(), "{bad}");
        }
    }
}
