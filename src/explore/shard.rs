//! One of n equal parts of a plan, for one of n machines: `2/5`.
//!
//! A point belongs to a shard by its key, so that neither the order of the plan nor what else is in it matters.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};

/// Part `number` (from 1) of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    pub number: u32,
    pub count: u32,
}

impl Shard {
    /// Whether the point of that key belongs here. Every key belongs to one shard of each count.
    pub fn holds(self, key: &str) -> bool {
        let hash = key.bytes().take(16).filter_map(|digit| char::from(digit).to_digit(16));
        let hash = hash.fold(0u64, |hash, digit| hash << 4 | u64::from(digit));
        hash % u64::from(self.count) + 1 == u64::from(self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, count)) if (1..=count).contains(&number) => Ok(Shard { number, count }),
            _ => Err(Error::usage(format!("'{text}' is no shard"))
                .help("write k/n with 1 <= k <= n, for example 2/5")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_belongs_to_one_shard() {
        let keys: Vec<String> =
            (0..200).map(|i: u32| blake3::hash(&i.to_le_bytes()).to_hex()[..32].to_string()).collect();
        for count in [1, 2, 7] {
            let mut sizes = vec![];
            for number in 1..=count {
                let shard = Shard { number, count };
                sizes.push(keys.iter().filter(|key| shard.holds(key)).count());
            }
            assert_eq!(sizes.iter().sum::<usize>(), keys.len());
            assert!(sizes.iter().all(|&size| size > keys.len() / count as usize / 2), "{sizes:?}");
        }
    }

    #[test]
    fn shards_count_from_one() {
        assert_eq!("2/5".parse::<Shard>().unwrap().to_string(), "2/5");
        for bad in ["0/5", "6/5", "5", "/", "a/b", "1/0"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
