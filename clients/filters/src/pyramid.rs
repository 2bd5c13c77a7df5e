//! A table of scores with tables of its maxima, which bound the scores of many poses at
//! once.
//!
//! Source: W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time loop closure in 2D LIDAR
//! SLAM*, ICRA 2016, §V.B: table k has the maxima over 2ᵏ × 2ᵏ cells, from the cell to the
//! upper right.

/// A table and its maxima.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    /// Cells to the left of and below the first one of the table.
    margin: i32,
    size: [i32; 2],
    /// The value of all cells beyond the table.
    beyond: u8,
    levels: Vec<Vec<u8>>,
}

impl Pyramid {
    /// Of a table (row by row, of this width and height), with `levels` tables in all.
    pub fn new(table: &[u8], [width, height]: [usize; 2], beyond: u8, levels: usize) -> Self {
        // A coarse cell that begins left of the table or below it reaches into it.
        let margin = (1 << (levels - 1)) - 1;
        let wide = width + margin;
        let mut finest = vec![beyond; wide * (height + margin)];
        for (row, line) in table.chunks(width.max(1)).enumerate() {
            let first = (row + margin) * wide + margin;
            finest[first..first + width].copy_from_slice(line);
        }
        let size = [wide as i32, (height + margin) as i32];
        let mut pyramid = Self { margin: margin as i32, size, beyond, levels: vec![finest] };
        for level in 1..levels {
            pyramid.levels.push(pyramid.maxima(level));
        }
        pyramid
    }

    /// The maxima over twice as many cells to each side as in the table before `level`.
    fn maxima(&self, level: usize) -> Vec<u8> {
        let (before, width) = (&self.levels[level - 1], self.size[0] as usize);
        let step = 1usize << (level - 1);
        let mut wide = before.clone();
        for (row, line) in wide.chunks_mut(width).zip(before.chunks(width)) {
            let right = line[step.min(width)..].iter().chain(std::iter::repeat(&self.beyond));
            row.iter_mut().zip(right).for_each(|(a, b)| *a = (*a).max(*b));
        }
        let mut both = wide.clone();
        let above = wide.get(step * width..).unwrap_or_default();
        let above = above.iter().chain(std::iter::repeat(&self.beyond));
        both.iter_mut().zip(above).for_each(|(a, b)| *a = (*a).max(*b));
        both
    }

    /// The value of all cells beyond the table.
    pub fn beyond(&self) -> u8 {
        self.beyond
    }

    /// The maximum of the 2^`level` × 2^`level` cells from this one on.
    pub fn most(&self, level: usize, column: i32, row: i32) -> u8 {
        let (x, y) = (column + self.margin, row + self.margin);
        let is_inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        if is_inside { self.levels[level][(y * self.size[0] + x) as usize] } else { self.beyond }
    }

    /// A bound of the sum of these cells, moved by `offset` and by up to 2^`level` − 1 cells
    /// more to the right and up. On level 0 it is the sum.
    pub fn sum(&self, level: usize, cells: &[[i32; 2]], offset: [i32; 2]) -> u32 {
        let of = |c: &[i32; 2]| u32::from(self.most(level, c[0] + offset[0], c[1] + offset[1]));
        cells.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_has_the_maxima_of_its_cells_and_what_is_beyond() {
        let (width, height) = (7, 5);
        let table: Vec<u8> = (0..width * height).map(|k| (k * 37 % 251) as u8).collect();
        for beyond in [0, 9, 200] {
            let pyramid = Pyramid::new(&table, [width, height], beyond, 4);
            let value = |x: i32, y: i32| {
                let is_inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
                if is_inside { table[(y * width as i32 + x) as usize] } else { beyond }
            };
            for (level, x, y) in (0..4)
                .flat_map(|level| (-9..12).flat_map(move |x| (-9..12).map(move |y| (level, x, y))))
            {
                let side = 1 << level;
                let cells = (0..side).flat_map(|dy| (0..side).map(move |dx| (x + dx, y + dy)));
                let most = cells.map(|(x, y)| value(x, y)).max().unwrap();
                assert_eq!(pyramid.most(level, x, y), most, "{level} {x} {y} {beyond}");
            }
        }
    }

    #[test]
    fn a_sum_bounds_those_of_all_offsets() {
        let table: Vec<u8> = (0..40 * 30).map(|k| (k * 89 % 256) as u8).collect();
        let pyramid = Pyramid::new(&table, [40, 30], 3, 4);
        let cells = [[3, 4], [20, -2], [31, 33], [0, 17]];
        let (bound, mut best) = (pyramid.sum(3, &cells, [-4, 2]), 0);
        for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x - 4, y + 2))) {
            let sum = pyramid.sum(0, &cells, [x, y]);
            assert!(sum <= bound, "{x} {y}: {sum} > {bound}");
            best = best.max(sum);
        }
        assert!(10 * best > 6 * bound, "{best} {bound}");
    }
}
