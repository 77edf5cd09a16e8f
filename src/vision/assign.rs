//! Who belongs to whom: the assignment of least total cost (Kuhn 1955, by shortest augmenting paths, Jonker and
//! Volgenant 1987).

/// For each row of a matrix with `cols` columns (row-major, at least as many columns as rows, finite), its column.
pub(super) fn assign(costs: &[f64], rows: usize, cols: usize) -> Vec<usize> {
    // Columns and rows count from 1; 0 is a row that stands for "none yet".
    let (mut row_price, mut col_price) = (vec![0.0; rows + 1], vec![0.0; cols + 1]);
    let mut row_of = vec![0; cols + 1];
    let mut before = vec![0; cols + 1];
    for row in 1..=rows {
        row_of[0] = row;
        let mut at = 0;
        let mut least = vec![f64::INFINITY; cols + 1];
        let mut done = vec![false; cols + 1];
        loop {
            done[at] = true;
            let (r, mut step, mut next) = (row_of[at], f64::INFINITY, 0);
            for col in 1..=cols {
                if done[col] {
                    continue;
                }
                let reduced = costs[(r - 1) * cols + col - 1] - row_price[r] - col_price[col];
                if reduced < least[col] {
                    least[col] = reduced;
                    before[col] = at;
                }
                if least[col] < step {
                    step = least[col];
                    next = col;
                }
            }
            for col in 0..=cols {
                if done[col] {
                    row_price[row_of[col]] += step;
                    col_price[col] -= step;
                } else {
                    least[col] -= step;
                }
            }
            at = next;
            if row_of[at] == 0 {
                break;
            }
        }
        while at != 0 {
            row_of[at] = row_of[before[at]];
            at = before[at];
        }
    }
    let mut columns = vec![0; rows];
    for (col, &row) in row_of.iter().enumerate().skip(1) {
        if row > 0 {
            columns[row - 1] = col - 1;
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::random::Key;

    fn least(costs: &[f64], rows: usize, cols: usize, row: usize, used: &mut Vec<bool>) -> f64 {
        if row == rows {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for col in 0..cols {
            if !used[col] {
                used[col] = true;
                best = best.min(costs[row * cols + col] + least(costs, rows, cols, row + 1, used));
                used[col] = false;
            }
        }
        best
    }

    #[test]
    fn no_other_assignment_costs_less() {
        for trial in 0..200 {
            let mut r = Key::new(1).child(trial).stream();
            let rows = 1 + r.index(5);
            let cols = rows + r.index(3);
            let costs: Vec<f64> = (0..rows * cols).map(|_| (r.unit() * 8.0).floor()).collect();
            let columns = assign(&costs, rows, cols);
            let mut sorted = columns.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), rows, "{columns:?}");
            let total: f64 = columns.iter().enumerate().map(|(row, col)| costs[row * cols + col]).sum();
            assert_eq!(total, least(&costs, rows, cols, 0, &mut vec![false; cols]), "{trial}");
        }
    }
}
