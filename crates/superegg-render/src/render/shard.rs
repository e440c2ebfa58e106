//! Shards: the division of work among independent renders.

use std::fmt;
use std::str::FromStr;

/// Shard K of N, written `K/N`, with K from 1 to N. It has every Nth item of a list, so that all
/// shards take about the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 1 to `count`.
    number: u32,
    count: u32,
}

impl Shard {
    /// The only shard of undivided work.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// Shard `number` of `count`; `None` unless 1 <= `number` <= `count`.
    pub fn new(number: u32, count: u32) -> Option<Self> {
        (1..=count).contains(&number).then_some(Self { number, count })
    }

    /// The number of the shard, from 1.
    pub fn number(self) -> u32 {
        self.number
    }

    /// The number of shards.
    pub fn count(self) -> u32 {
        self.count
    }

    /// Whether the item at an index, counted from 0, is in the shard.
    pub fn takes(self, index: usize) -> bool {
        index as u64 % u64::from(self.count) == u64::from(self.number - 1)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok());
        let parts =
            text.split_once('/').and_then(|(number, count)| Some((digits(number)??, digits(count)??)));
        let (number, count) = parts.ok_or("expected a shard K/N, such as 2/8, the second of eight")?;
        if count == 0 {
            return Err(
                "the number of shards must be above 0; a shard is K/N, such as 2/8, the second of eight"
                    .to_owned(),
            );
        }
        Self::new(number, count).ok_or_else(|| format!("the shard must be from 1 to {count}, not {number}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_item_is_in_one_shard() {
        for count in [1, 2, 3, 7, 100] {
            let shards: Vec<Shard> = (1..=count).map(|number| Shard::new(number, count).unwrap()).collect();
            for index in 0..50 {
                let takers: Vec<&Shard> = shards.iter().filter(|shard| shard.takes(index)).collect();
                assert_eq!(takers, [&shards[index % count as usize]]);
            }
        }
        assert!((0..50).all(|index| Shard::WHOLE.takes(index)));
    }

    #[test]
    fn shards_read_back() {
        for text in ["1/1", "2/8", "4294967295/4294967295"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for bad in
            ["", "/", "1", "1/", "/1", "0/3", "4/3", "0/0", "-1/3", "+1/3", "1/3/5", " 1/3", "1/99999999999"]
        {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
