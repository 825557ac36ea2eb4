// Incomplete LU factors of a matrix of 4 x 4 node blocks, for two halves of a rank's rows at once:
// rows lie in the order of their place, so that halves are compact, and two cores factorise and
// solve side by side. The halves stay two whatever the threads, and so does every result. Seen only
// inside fem.
#pragma once

#include <array>
#include <vector>

#include "fem/block_matrix.hpp"

namespace sanatrix::fem {

class BlockFactors {
 public:
  /// The pattern of a rank's own rows and columns, which outlives this object.
  BlockFactors(const BlockRows& pattern, int rows);
  ~BlockFactors();
  BlockFactors(const BlockFactors&) = delete;
  BlockFactors& operator=(const BlockFactors&) = delete;

  /// Factors of these values with so many levels of fill. False where a pivot vanishes.
  bool update(const BlockRows& values, int levels_of_fill);
  /// z = (LU)^-1 r, of all own rows.
  void apply(const double* r, double* z);

 private:
  class Half;
  std::vector<Half> halves_;
};

}  // namespace sanatrix::fem
