//! Dense kernels behind plain functions on ndarray views.
