#include "step/block_matrix.h"

#include <algorithm>

#include "math/dense.h"

namespace contact_toolkit {
namespace {

// c -= a b, a of (rows, inner), b of (inner, columns).
void SubtractProduct(int rows, int inner, int columns, const double* a, const double* b,
                     double* c) {
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < inner; ++k) {
      const double factor = a[i * inner + k];
      for (int j = 0; j < columns; ++j) c[i * columns + j] -= factor * b[k * columns + j];
    }
  }
}

}  // namespace

void BlockMatrix::Reset(std::span<const int> block_sizes,
                        std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  num_blocks_ = block_sizes.size();
  sizes_.assign(block_sizes.begin(), block_sizes.end());
  starts_.resize(num_blocks_);
  num_rows_ = 0;
  for (std::size_t i = 0; i < num_blocks_; ++i) {
    starts_[i] = num_rows_;
    num_rows_ += sizes_[i];
  }
  Order(edges);
  index_.assign(num_blocks_ * num_blocks_, kNone);
  std::int64_t end = 0;
  const auto add = [&](int i, int j) {
    index_[i * num_blocks_ + j] = end;
    end += static_cast<std::int64_t>(sizes_[i]) * sizes_[j];
  };
  for (const int k : order_) {
    add(k, k);
    for (const int j : later_[k]) add(k, j), add(j, k);
  }
  values_.assign(end, 0.0);
  pivots_.resize(num_rows_);
}

void BlockMatrix::Order(std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  if (later_.size() < num_blocks_) later_.resize(num_blocks_);
  for (std::size_t i = 0; i < num_blocks_; ++i) later_[i].clear();
  for (const auto& [i, j] : edges) {
    if (i == j) continue;
    later_[i].push_back(j);
    later_[j].push_back(i);
  }
  const auto tidy = [](std::vector<int>& neighbours) {
    std::ranges::sort(neighbours);
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  };
  for (std::size_t i = 0; i < num_blocks_; ++i) tidy(later_[i]);
  std::vector<bool> done(num_blocks_, false);
  order_.clear();
  std::vector<int> merged;
  while (order_.size() < num_blocks_) {
    int best = -1;
    for (std::size_t i = 0; i < num_blocks_; ++i) {
      if (!done[i] && (best < 0 || later_[i].size() < later_[best].size())) best = i;
    }
    done[best] = true;
    order_.push_back(best);
    for (const int i : later_[best]) {  // its neighbours become neighbours of each other
      merged.clear();
      std::ranges::set_union(later_[i], later_[best], std::back_inserter(merged));
      std::erase_if(merged, [&](int j) { return j == i || j == best; });
      later_[i] = merged;
    }
  }
}

bool BlockMatrix::Factor() {
  for (const int k : order_) {
    const int n = sizes_[k];
    double* diagonal = Block(k, k);
    int* pivot = pivots_.data() + starts_[k];
    if (!FactorLu(n, diagonal, pivot)) return false;
    for (const int j : later_[k]) SolveLu(n, diagonal, pivot, sizes_[j], Block(k, j));
    for (const int i : later_[k]) {
      const double* left = Block(i, k);
      for (const int j : later_[k]) {
        SubtractProduct(sizes_[i], n, sizes_[j], left, Block(k, j), Block(i, j));
      }
    }
  }
  return true;
}

bool BlockMatrix::DeterminantIsNegative() const {
  bool negative = false;
  for (std::size_t k = 0; k < num_blocks_; ++k) {
    const double* diagonal = values_.data() + index_[k * num_blocks_ + k];
    for (int i = 0; i < sizes_[k]; ++i) {
      const bool swapped = pivots_[starts_[k] + i] != i;
      negative ^= swapped ^ (diagonal[i * sizes_[k] + i] < 0);
    }
  }
  return negative;
}

void BlockMatrix::Solve(std::span<double> x) const {
  const auto block = [&](int i, int j) { return values_.data() + index_[i * num_blocks_ + j]; };
  for (const int k : order_) {
    double* mine = x.data() + starts_[k];
    SolveLu(sizes_[k], block(k, k), pivots_.data() + starts_[k], 1, mine);
    for (const int i : later_[k]) {
      SubtractProduct(sizes_[i], sizes_[k], 1, block(i, k), mine, x.data() + starts_[i]);
    }
  }
  for (auto k = order_.rbegin(); k != order_.rend(); ++k) {
    for (const int j : later_[*k]) {
      SubtractProduct(sizes_[*k], sizes_[j], 1, block(*k, j), x.data() + starts_[j],
                      x.data() + starts_[*k]);
    }
  }
}

}  // namespace contact_toolkit
