// The MPI ranks of one run as the pipeline sees them. Rank 0 alone writes files and talks.
#pragma once

namespace sanatrix::pipeline {

class Team {
 public:
  virtual ~Team() = default;
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  /// The value of rank 0, on every rank; also a barrier.
  virtual long share(long value_of_rank_0) = 0;
  [[nodiscard]] bool leads() const { return rank() == 0; }
};

/// One process.
class Alone final : public Team {
 public:
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  long share(long value) override { return value; }
};

}  // namespace sanatrix::pipeline
