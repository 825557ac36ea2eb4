// Products of 4 x 4 node blocks, stored by columns, four numbers in a register at a time. Seen only
// inside fem.
#pragma once

#include <array>
#include <cstddef>

namespace sanatrix::fem {

// Without AVX these are two registers, whose ABI matters to nobody: all of this is inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

using Four = double __attribute__((vector_size(32)));

/// Four doubles in memory.
using FourAnywhere = double __attribute__((vector_size(32), aligned(8), may_alias));
inline FourAnywhere& four(double* at) {
  return *reinterpret_cast<FourAnywhere*>(at);
}
inline Four four(const double* at) {
  return *reinterpret_cast<const FourAnywhere*>(at);
}

/// At the beginning of a cache line.
struct alignas(64) AlignedBlock {
  std::array<double, 16> entries;
};

inline Four column(const double* A, std::size_t k) {
  return four(A + 4 * k);
}
inline Four column(const AlignedBlock& A, std::size_t k) {
  return column(A.entries.data(), k);
}

/// A x; A by its columns, x by its entries.
template <class Matrix, class Vector>
Four product(const Matrix& A, const Vector& x) {
  return column(A, 0) * x[0] + column(A, 1) * x[1] + column(A, 2) * x[2] + column(A, 3) * x[3];
}

}  // namespace sanatrix::fem
