//! Where labels go: beside their line, where they cover the least of what is there.

/// Size of letters of labels, and width of one relative to it.
pub const LETTER: f64 = 12.0;
const LETTER_WIDTH: f64 = 0.5;

/// A box: left, top, right, bottom.
type Taken = [f64; 4];

/// The labels of a panel.
pub struct Labels {
    frame: Taken,
    taken: Vec<Taken>,
}

impl Labels {
    /// No labels yet, in a frame.
    pub fn new(frame: Taken) -> Self {
        Self {
            frame,
            taken: Vec::new(),
        }
    }

    /// Keeps clear of the markers of a line, and of the line between them.
    pub fn keep_clear(&mut self, points: &[[f64; 2]]) {
        let mut around = |[x, y]: [f64; 2], half: f64| {
            self.taken.push([x - half, y - half, x + half, y + half]);
        };
        for &point in points {
            around(point, 6.0);
        }
        for ends in points.windows(2) {
            let [dx, dy] = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
            let parts = (dx.abs().max(dy.abs()) / 6.0).ceil();
            for part in 1..parts as u32 {
                let share = f64::from(part) / parts;
                around([ends[0][0] + share * dx, ends[0][1] + share * dy], 2.0);
            }
        }
    }

    /// Where a label of a line starts; it is taken then.
    pub fn place(&mut self, points: &[[f64; 2]], label: &str) -> [f64; 2] {
        // A little more than letters take, so that labels do not touch.
        let wide = LETTER * LETTER_WIDTH * label.chars().count() as f64 + 4.0;
        let [left, top, right, bottom] = self.frame;
        let mut best = (f64::INFINITY, [left, top], [0.0; 4]);
        for (rank, &[x, y]) in points.iter().enumerate() {
            for (turn, [dx, dy]) in around(wide).into_iter().enumerate() {
                let at = [
                    (x + dx).clamp(left + 4.0, (right - wide).max(left + 4.0)),
                    (y + dy).clamp(top + LETTER + 2.0, bottom - 6.0),
                ];
                let own = [at[0], at[1] - LETTER, at[0] + wide, at[1] + 3.0];
                let covered: f64 = self.taken.iter().map(|other| overlap(&own, other)).sum();
                // Close ones are worth a little overlap: they are told from labels of other lines. Among equals the first.
                let away =
                    (at[0] - x - dx).abs() + (at[1] - y - dy).abs() + 3.0 * (turn / 8) as f64;
                let cost = covered + 8.0 * away + 0.01 * (rank + turn) as f64;
                if cost < best.0 {
                    best = (cost, at, own);
                }
            }
        }
        self.taken.push(best.2);
        best.1
    }
}

/// Places around a marker for a label, the better ones first.
fn around(wide: f64) -> Vec<[f64; 2]> {
    let mut places = Vec::new();
    for far in [0.0, 8.0, 18.0] {
        places.extend([
            [9.0 + far, 4.0],
            [-9.0 - wide - far, 4.0],
            [-wide / 2.0, -11.0 - far],
            [-wide / 2.0, 21.0 + far],
            [5.0, -9.0 - far],
            [5.0, 19.0 + far],
            [-wide - 3.0, -9.0 - far],
            [-wide - 3.0, 19.0 + far],
        ]);
    }
    places
}

fn overlap(a: &Taken, b: &Taken) -> f64 {
    let wide = a[2].min(b[2]) - a[0].max(b[0]);
    let high = a[3].min(b[3]) - a[1].max(b[1]);
    wide.max(0.0) * high.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two labels of one point, and one more line through the first place: none covers another.
    #[test]
    fn labels_keep_clear_of_each_other() {
        let mut labels = Labels::new([0.0, 0.0, 400.0, 300.0]);
        labels.keep_clear(&[[100.0, 150.0], [300.0, 150.0]]);
        for _ in 0..3 {
            let before = labels.taken.clone();
            let [x, y] = labels.place(&[[100.0, 150.0]], "a label");
            let own = labels.taken[before.len()];
            assert!((own[0], own[3]) == (x, y + 3.0));
            assert!(before.iter().all(|other| overlap(&own, other) == 0.0));
        }
    }
}
