//! The order of row-major output: the strips along the input strip, in chunks (Hall, section 4.6).
//!
//! ```text
//! columns    0  1  2  3 | 3  4  5  6 | 6  7          N = 4: neighbouring chunks share a column
//! row 0      1→ 2→ 3→ 4   9→ ...                     then row 1 of the chunk, and so on
//! row 1      5→ 6→ 7→ 8
//! ```

/// A vertex as it is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent<P> {
    pub vertex: P,
    /// The last one of its row within the chunk, of the chunk, of the strip.
    pub row_end: bool,
    pub chunk_end: bool,
    pub strip_end: bool,
}

/// The vertices of a fine strip in the order in which they are sent, at most `longest` columns a chunk.
///
/// `columns` are those of one strip, each from top to bottom and all of one length; `longest` is at least 2.
pub fn rows_of<P: Clone>(columns: &[Vec<P>], longest: usize) -> Vec<Sent<P>> {
    let mut sent = vec![];
    let quads = columns.len().saturating_sub(1);
    // Chunks by their quads: N columns have N-1 of them. A strip of one column is one chunk.
    for first in (0..quads.max(1)).step_by(longest.max(2) - 1) {
        let last = (first + longest.max(2) - 1).min(quads);
        let Some(chunk) = columns.get(first..=last) else { break };
        let rows = chunk.first().map_or(0, Vec::len);
        for row in 0..rows {
            for (place, column) in chunk.iter().enumerate() {
                let row_end = place + first == last;
                let chunk_end = row_end && row + 1 == rows;
                let vertex = column[row].clone();
                sent.push(Sent { vertex, row_end, chunk_end, strip_end: chunk_end && last == quads });
            }
        }
    }
    sent
}

/// Clocks in which nothing stalls, from the first column at the input to the last vertex at the output, for strips
/// of `columns` columns and `rows` rows one after the other: a chunk is written in as many clocks as it has
/// vertices, is sent in as many, and the next one is written at the same time.
pub fn clocks(strips: &[(usize, usize)], longest: usize) -> u64 {
    let chunks = |&(columns, rows): &(usize, usize)| {
        let sent = rows_of(&vec![vec![(); rows]; columns], longest);
        sent.chunk_by(|vertex, _| !vertex.chunk_end).map(|chunk| chunk.len() as u64).collect::<Vec<_>>()
    };
    let (mut before, mut written, mut sent) = (0, 0, 0);
    for chunk in strips.iter().flat_map(chunks) {
        // A half is free again when the chunk before the last one has been sent.
        written = u64::max(written, before) + chunk;
        before = sent;
        sent = u64::max(written, sent) + chunk;
    }
    // The word that is read in a clock stands at the output in the next one.
    sent + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(columns: usize, rows: usize, longest: usize) -> Vec<(usize, usize)> {
        let strip: Vec<Vec<(usize, usize)>> =
            (0..columns).map(|c| (0..rows).map(|r| (c, r)).collect()).collect();
        rows_of(&strip, longest).into_iter().map(|s| s.vertex).collect()
    }

    #[test]
    fn chunks_share_a_column_and_rows_come_one_after_the_other() {
        let expected = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (2, 0), (3, 0), (2, 1), (3, 1)];
        assert_eq!(order(4, 2, 3), expected);
        // A strip that ends with a full chunk has no other one behind it.
        assert_eq!(order(5, 1, 3).len(), 6);
        assert_eq!(order(3, 2, 8), expected[..6]);
    }

    #[test]
    fn ends_are_marked() {
        let strip: Vec<Vec<u32>> = vec![vec![0, 1]; 4];
        let sent = rows_of(&strip, 3);
        let marked = |which: fn(&Sent<u32>) -> bool| -> Vec<usize> {
            (0..sent.len()).filter(|&i| which(&sent[i])).collect()
        };
        assert_eq!(marked(|s| s.row_end), [2, 5, 7, 9]);
        assert_eq!(marked(|s| s.chunk_end), [5, 9]);
        assert_eq!(marked(|s| s.strip_end), [9]);
    }

    #[test]
    fn long_strips_take_a_clock_a_vertex_and_one_chunk_before() {
        // Ten chunks of 4 columns and 3 rows.
        assert_eq!(clocks(&[(31, 3)], 4), 12 + 120 + 1);
        assert_eq!(clocks(&[(4, 3)], 4), 25);
    }
}
