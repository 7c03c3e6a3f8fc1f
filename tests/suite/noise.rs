//! Deterministic random numbers for tests.

/// Vigna's splitmix64; the seed decides everything.
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// 0 .. n, without n.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }

    /// True this often in a hundred.
    pub fn percent(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// Any number of 128 bits.
    pub fn wide(&mut self) -> i128 {
        (u128::from(self.next()) << 64 | u128::from(self.next())) as i128
    }
}

/// The same numbers for meshes, which count in `usize`.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        let mut noise = Noise(self.0);
        let bits = noise.next();
        self.0 = noise.0;
        bits
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A coordinate of `width` bits; one in four is an extreme one.
    pub fn coordinate(&mut self, width: u32) -> i64 {
        match self.below(8) {
            0 => -(1 << (width - 1)),
            1 => (1 << (width - 1)) - 1,
            _ => (self.bits() as i64) >> (64 - width),
        }
    }
}
