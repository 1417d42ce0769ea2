//! Lists that are walked from end to end at every evaluation, in large pages of memory.
//!
//! A scene of 100 000 links touches some thirty thousand pages of four kilobytes in one evaluation, and at each of them the
//! processor walks the page tables and its prefetching begins anew. In pages of two megabytes, which the system is asked
//! for where it has them (Linux), that is gone: docs/speed.md, “Large pages”, has the numbers. Lists shorter than
//! one such page lie where every other list does.

use allocator_api2::vec::Vec as InAllocator;
use hugealloc::HugeAlloc;
use std::ops::{Deref, DerefMut};

/// A list of fixed length that behaves like a slice.
///
/// ```
/// let mut list = stillpoint::pages::Pages::filled(0.0, 3);
/// list[1] = 2.0;
/// assert_eq!(list.iter().sum::<f64>(), 2.0);
/// ```
#[derive(Debug, Clone)]
pub struct Pages<T>(InAllocator<T, HugeAlloc>);

impl<T: Clone> Pages<T> {
    /// `length` copies of one value.
    pub fn filled(value: T, length: usize) -> Self {
        let mut list = InAllocator::with_capacity_in(length, HugeAlloc);
        list.resize(length, value);
        Self(list)
    }
}

impl<T> FromIterator<T> for Pages<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut list = InAllocator::new_in(HugeAlloc);
        list.extend(items);
        Self(list)
    }
}

impl<T> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T> DerefMut for Pages<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

impl<'a, T> IntoIterator for &'a Pages<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut Pages<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}

impl<T> Default for Pages<T> {
    fn default() -> Self {
        Self(InAllocator::new_in(HugeAlloc))
    }
}

#[cfg(test)]
mod tests {
    use super::Pages;

    #[test]
    fn long_lists_begin_with_a_large_page() {
        const LARGE: usize = 2 << 20;
        let long = Pages::filled(0_u8, 3 * LARGE);
        assert_eq!(long.as_ptr() as usize % LARGE, 0);
        let collected: Pages<u64> = (0..LARGE as u64).collect();
        assert_eq!(collected.as_ptr() as usize % LARGE, 0);
        assert_eq!(collected[LARGE - 1], LARGE as u64 - 1);
    }
}
