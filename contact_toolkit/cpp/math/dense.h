// Dense factorizations of small square matrices, row-major, in place.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

namespace contact_toolkit {

// A = L Lᵀ; L replaces the lower triangle. False where A is not positive definite.
inline bool FactorCholesky(int n, double* a) {
  for (int j = 0; j < n; ++j) {
    double diagonal = a[j * n + j];
    for (int k = 0; k < j; ++k) diagonal -= a[j * n + k] * a[j * n + k];
    if (!(diagonal > 0)) return false;
    const double root = std::sqrt(diagonal);
    a[j * n + j] = root;
    for (int i = j + 1; i < n; ++i) {
      double sum = a[i * n + j];
      for (int k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = sum / root;
    }
  }
  return true;
}

// x = L⁻¹ x, so that |x|² becomes xᵀ A⁻¹ x.
inline void SolveLower(int n, const double* l, double* x) {
  for (int i = 0; i < n; ++i) {
    double sum = x[i];
    for (int k = 0; k < i; ++k) sum -= l[i * n + k] * x[k];
    x[i] = sum / l[i * n + i];
  }
}

// x = L⁻ᵀ x.
inline void SolveLowerTransposed(int n, const double* l, double* x) {
  for (int i = n - 1; i >= 0; --i) {
    double sum = x[i];
    for (int k = i + 1; k < n; ++k) sum -= l[k * n + i] * x[k];
    x[i] = sum / l[i * n + i];
  }
}

// P A = L U with row pivots; false where a pivot vanishes.
inline bool FactorLu(int n, double* a, int* pivot) {
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(a[i * n + k]) > std::abs(a[best * n + k])) best = i;
    }
    pivot[k] = best;
    if (!(std::abs(a[best * n + k]) > 0)) return false;
    if (best != k) {
      for (int j = 0; j < n; ++j) std::swap(a[k * n + j], a[best * n + j]);
    }
    const double inverse = 1 / a[k * n + k];
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] *= inverse;
      if (factor == 0) continue;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return true;
}

// X = A⁻¹ X for X of `columns` columns, row-major.
inline void SolveLu(int n, const double* lu, const int* pivot, int columns, double* x) {
  for (int k = 0; k < n; ++k) {
    if (pivot[k] == k) continue;
    for (int j = 0; j < columns; ++j) std::swap(x[k * columns + j], x[pivot[k] * columns + j]);
  }
  for (int i = 1; i < n; ++i) {
    for (int k = 0; k < i; ++k) {
      const double factor = lu[i * n + k];
      if (factor == 0) continue;
      for (int j = 0; j < columns; ++j) x[i * columns + j] -= factor * x[k * columns + j];
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) {
      const double factor = lu[i * n + k];
      if (factor == 0) continue;
      for (int j = 0; j < columns; ++j) x[i * columns + j] -= factor * x[k * columns + j];
    }
    const double inverse = 1 / lu[i * n + i];
    for (int j = 0; j < columns; ++j) x[i * columns + j] *= inverse;
  }
}

}  // namespace contact_toolkit
