//! Views of image buffers that belong to the caller: rows of pixels, a stride apart.

use crate::error::{Error, Result};

/// An image to read. Row `r` begins at element `r * stride`.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a, T> {
    data: &'a [T],
    rows: usize,
    cols: usize,
    stride: usize,
}

/// An image to write. Row `r` begins at element `r * stride`; what lies between the rows is left as it is.
#[derive(Debug)]
pub struct ImageMut<'a, T> {
    data: &'a mut [T],
    rows: usize,
    cols: usize,
    stride: usize,
}

/// Refuses a buffer that is too small for its rows, or rows that overlap.
fn check(length: usize, rows: usize, cols: usize, stride: usize) -> Result<()> {
    if rows == 0 || cols == 0 {
        return Err(Error::argument("image", format!("has {rows} rows and {cols} columns; it needs at least one")));
    }
    if stride < cols {
        return Err(Error::argument("image.stride", format!("is {stride}; a row has {cols} pixels")));
    }
    let needed = (rows - 1).checked_mul(stride).and_then(|n| n.checked_add(cols));
    match needed {
        Some(needed) if needed <= length => Ok(()),
        _ => Err(Error::argument(
            "image",
            format!("its buffer has {length} pixels; {rows} rows of {cols}, {stride} apart, do not fit"),
        )),
    }
}

impl<'a, T> Image<'a, T> {
    /// An image whose rows follow each other without a gap.
    pub fn packed(data: &'a [T], rows: usize, cols: usize) -> Result<Self> {
        Self::new(data, rows, cols, cols)
    }

    /// `stride` is the distance from row to row in elements.
    pub fn new(data: &'a [T], rows: usize, cols: usize, stride: usize) -> Result<Self> {
        check(data.len(), rows, cols, stride)?;
        Ok(Self { data, rows, cols, stride })
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn cols(&self) -> usize {
        self.cols
    }

    #[inline]
    pub fn row(&self, row: usize) -> &'a [T] {
        &self.data[row * self.stride..][..self.cols]
    }
}

impl<'a, T> ImageMut<'a, T> {
    /// An image whose rows follow each other without a gap.
    pub fn packed(data: &'a mut [T], rows: usize, cols: usize) -> Result<Self> {
        Self::new(data, rows, cols, cols)
    }

    /// `stride` is the distance from row to row in elements.
    pub fn new(data: &'a mut [T], rows: usize, cols: usize, stride: usize) -> Result<Self> {
        check(data.len(), rows, cols, stride)?;
        Ok(Self { data, rows, cols, stride })
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn cols(&self) -> usize {
        self.cols
    }

    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.data[row * self.stride..][..self.cols]
    }

    pub fn as_image(&self) -> Image<'_, T> {
        Image { data: self.data, rows: self.rows, cols: self.cols, stride: self.stride }
    }
}

impl<T: Copy> ImageMut<'_, T> {
    /// Sets every pixel.
    pub fn fill(&mut self, value: T) {
        for row in 0..self.rows {
            self.row_mut(row).fill(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_row_needs_no_padding_and_a_short_buffer_is_refused() {
        let mut data = [0u8; 11];
        let mut image = ImageMut::new(&mut data, 3, 3, 4).unwrap();
        image.fill(7);
        assert_eq!(image.as_image().row(2), [7; 3]);
        assert_eq!(data, [7, 7, 7, 0, 7, 7, 7, 0, 7, 7, 7]);
        assert!(Image::new(&data[..10], 3, 3, 4).unwrap_err().to_string().contains("do not fit"));
        assert!(Image::new(&data, 3, 3, 2).unwrap_err().to_string().starts_with("image.stride: is 2"));
        assert!(Image::new(&data, usize::MAX, 3, usize::MAX).is_err());
        assert!(Image::packed(&data, 0, 3).is_err());
    }
}
