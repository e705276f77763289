//! Sets of small indices as words of bits.

/// Rows of equal length, each a set of indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BitRows {
    words: usize,
    bits: Vec<u64>,
}

impl BitRows {
    /// `rows` empty sets of indices below `len`.
    pub fn new(rows: usize, len: usize) -> Self {
        let words = words_for(len);
        Self { words, bits: vec![0; rows * words] }
    }

    /// One set.
    pub fn row(&self, row: usize) -> &[u64] {
        &self.bits[row * self.words..(row + 1) * self.words]
    }

    /// One set, to be changed.
    pub fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.bits[row * self.words..(row + 1) * self.words]
    }
}

/// Number of words of a set of indices below `len`.
pub(crate) fn words_for(len: usize) -> usize {
    len.div_ceil(64)
}

pub(crate) fn insert(set: &mut [u64], index: usize) {
    set[index / 64] |= 1 << (index % 64);
}

pub(crate) fn remove(set: &mut [u64], index: usize) {
    set[index / 64] &= !(1 << (index % 64));
}

pub(crate) fn contains(set: &[u64], index: usize) -> bool {
    set[index / 64] >> (index % 64) & 1 == 1
}

pub(crate) fn count(set: &[u64]) -> u32 {
    set.iter().map(|word| word.count_ones()).sum()
}

pub(crate) fn unite(set: &mut [u64], other: &[u64]) {
    set.iter_mut().zip(other).for_each(|(word, more)| *word |= more);
}

/// Least index at or above `from`.
pub(crate) fn next_from(set: &[u64], from: usize) -> Option<usize> {
    let mut word = from / 64;
    let mut rest = set.get(word)? & (u64::MAX << (from % 64));
    while rest == 0 {
        word += 1;
        rest = *set.get(word)?;
    }
    Some(word * 64 + rest.trailing_zeros() as usize)
}

/// Greatest index.
pub(crate) fn greatest(set: &[u64]) -> Option<usize> {
    let word = set.iter().rposition(|word| *word != 0)?;
    Some(word * 64 + 63 - set[word].leading_zeros() as usize)
}

/// All indices, ascending.
pub(crate) fn indices(set: &[u64]) -> impl Iterator<Item = usize> + '_ {
    let mut from = 0;
    std::iter::from_fn(move || {
        let index = next_from(set, from)?;
        from = index + 1;
        Some(index)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_come_back_in_order_across_words() {
        let mut rows = BitRows::new(2, 200);
        let wanted = [0, 1, 63, 64, 127, 128, 199];
        wanted.iter().for_each(|i| insert(rows.row_mut(1), *i));
        assert_eq!(indices(rows.row(1)).collect::<Vec<_>>(), wanted);
        assert_eq!(indices(rows.row(0)).count(), 0);
        assert_eq!((next_from(rows.row(1), 65), next_from(rows.row(1), 200)), (Some(127), None));
        assert_eq!((greatest(rows.row(1)), greatest(rows.row(0)), count(rows.row(1))), (Some(199), None, 7));
        remove(rows.row_mut(1), 64);
        assert!(!contains(rows.row(1), 64) && contains(rows.row(1), 63));
    }
}
