// A square matrix of dense blocks with a symmetric pattern, and its LU factors. Blocks are
// eliminated in an order of least degree (Tinney and Walker, Proc. IEEE 55(11), 1967), without
// pivoting across blocks: what is factored here is a mass matrix plus contact stiffness, whose
// diagonal blocks stay regular.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace contact_toolkit {

class BlockMatrix {
 public:
  // Zero everywhere, with blocks on the diagonal and, both ways round, for each pair of `edges`
  // (which may repeat). Storage is kept between uses.
  void Reset(std::span<const int> block_sizes,
             std::span<const std::pair<std::int32_t, std::int32_t>> edges);

  // Block (i, j), row-major; i == j or an edge.
  double* Block(int i, int j) { return values_.data() + index_[i * num_blocks_ + j]; }

  // The matrix is lost to its factors. False where a diagonal block is singular.
  bool Factor();

  // x = A⁻¹ x, after Factor().
  void Solve(std::span<double> x) const;

  // Of A, after Factor().
  bool DeterminantIsNegative() const;

  int size_of(int i) const { return sizes_[i]; }
  int start_of(int i) const { return starts_[i]; }
  int num_rows() const { return num_rows_; }

 private:
  static constexpr std::int64_t kNone = -1;

  void Order(std::span<const std::pair<std::int32_t, std::int32_t>> edges);

  std::size_t num_blocks_ = 0;
  int num_rows_ = 0;
  std::vector<int> sizes_, starts_;
  std::vector<int> order_;               // of elimination
  std::vector<std::vector<int>> later_;  // neighbours of each block when it is eliminated
  std::vector<std::int64_t> index_;      // where block (i, j) starts; kNone: zero
  std::vector<double> values_;
  std::vector<int> pivots_;
  std::vector<double> product_;
};

}  // namespace contact_toolkit
