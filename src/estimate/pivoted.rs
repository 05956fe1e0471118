//! A column-pivoted Householder QR before anything is said about rank: faer's, sequential, with `Q` formed explicitly, or for few rows that of `small_qr.rs`.

use super::small_qr::{self, Pivoted};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::{householder, qr};
use faer::{Conj, Mat, Par};

/// From so many rows on reflections are applied one by one: joining them into blocks would pack kilobytes for each row.
const TALL: usize = 8192;
/// Column-pivoted Householder QR of the columns `active` of `scaled`, whose norms are 1.
#[allow(clippy::indexing_slicing, reason = "`order` holds places among `active`: a permutation of them")]
pub(super) fn pivoted_qr(scaled: &Mat<f64>, active: &[usize], tolerance: f64) -> Pivoted {
    let (m, k) = (scaled.nrows(), active.len());
    let size = m.min(k);
    if m * k <= small_qr::MOST {
        return small_qr::pivoted(scaled, active, tolerance);
    }
    let mut work = Mat::zeros(m, k);
    for (l, &j) in active.iter().enumerate() {
        work.col_as_slice_mut(l).copy_from_slice(scaled.col_as_slice(j));
    }
    let block = match m > TALL {
        true => 1,
        false => qr::no_pivoting::factor::recommended_block_size::<f64>(m, k).clamp(1, size.max(1)),
    };
    let mut coefficients = Mat::zeros(block, size);
    let (mut order, mut inverse) = (vec![0_usize; k], vec![0_usize; k]);
    let needed = StackReq::any_of(&[
        qr::col_pivoting::factor::qr_in_place_scratch::<usize, f64>(m, k, block, Par::Seq, Default::default()),
        householder::apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(m, block, size),
    ]);
    let mut memory = MemBuffer::new(needed);
    let stack = MemStack::new(&mut memory);
    qr::col_pivoting::factor::qr_in_place(
        work.as_mut(),
        coefficients.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        stack,
        Default::default(),
    );
    let mut q = Mat::zeros(m, size);
    q.diagonal_mut().fill(1.0);
    householder::apply_block_householder_sequence_on_the_left_in_place_with_conj(
        work.subcols(0, size),
        coefficients.as_ref(),
        Conj::No,
        q.as_mut(),
        Par::Seq,
        stack,
    );
    order.iter_mut().for_each(|l| *l = active[*l]);
    Pivoted::new(q, work.subrows(0, size).to_owned(), order, tolerance)
}
