//! The back end's functions, compiled once for each of the two kinds of numbers.
//!
//! A generic function is compiled again in every crate that calls it, and those of a back
//! end are long. The functions here belong to a type, are not generic, and are compiled in
//! this crate alone. Each leaves the registers as scalar code wants them.

use crate::backend::{self, Triangle};
use crate::{upper_halves, Result};
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2};
use num_complex::Complex64;

macro_rules! doors {
    ($(fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        /// One door to each function of the back end that takes both kinds.
        pub trait Doors: Sized {
            $(fn $name($($argument: $type),*) $(-> $result)?;)*
        }
        doors!(@of f64: $(fn $name($($argument: $type),*) $(-> $result)?;)*);
        doors!(@of Complex64: $(fn $name($($argument: $type),*) $(-> $result)?;)*);
    };
    (@of $number:ty: $(fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        impl Doors for $number {
            $(
                #[inline(never)]
                fn $name($($argument: $type),*) $(-> $result)? {
                    let result = backend::$name($($argument),*);
                    upper_halves::clear();
                    result
                }
            )*
        }
    };
}

doors! {
    fn matmul(a: ArrayView2<Self>, adjoint: bool, b: ArrayView2<Self>) -> Array2<Self>;
    fn product(c: ArrayViewMut2<Self>, add: bool, a: ArrayView2<Self>, adjoint: bool, b: ArrayView2<Self>);
    fn qr_thin(a: ArrayView2<Self>) -> (Array2<Self>, Array2<Self>);
    fn qr_r(a: ArrayView2<Self>) -> Array2<Self>;
    fn svd_thin(a: ArrayView2<Self>) -> Result<(Array2<Self>, Array1<f64>, Array2<Self>)>;
    fn singular_values(a: ArrayView2<Self>) -> Result<Array1<f64>>;
    fn eigh(a: ArrayView2<Self>) -> Result<(Array1<f64>, Array2<Self>)>;
    fn cholesky(a: ArrayView2<Self>) -> Result<Array2<Self>>;
    fn solve_triangular(t: ArrayView2<Self>, b: ArrayView2<Self>, which: Triangle) -> Array2<Self>;
}
