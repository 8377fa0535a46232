#include "query/solid/winding.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/tolerances.h"

namespace contact_toolkit {
namespace {

constexpr int kRounds = 8;  // of choosing sheets; each lowers the imbalance or is the last

class Finder {
 public:
  explicit Finder(const CollisionMesh& mesh)
      : mesh_(mesh), faces_(mesh.faces()), count_(static_cast<std::int32_t>(faces_.size())) {}

  Winding Find() {
    result_.turn.assign(count_, 1);
    agreement_.assign(count_, 1);
    LeaveOutCollapsed();
    LeaveOutDuplicates();
    ListUsers();
    Peel();
    FindSheets();
    OrientSheets();
    FindClusters();
    ChooseSheets();
    for (std::int32_t f = 0; f < count_; ++f) {
      if (result_.turn[f] < 0) result_.turned.push_back(f);
    }
    result_.cluster_open.assign(result_.num_clusters, 0);
    for (std::size_t e = 0; e < users_.size(); ++e) {
      if (Imbalance(static_cast<std::int32_t>(e)) == 0) continue;
      result_.balanced = false;
      result_.cluster_open[result_.cluster[users_[e][0].facet]] = 1;
    }
    return std::move(result_);
  }

 private:
  struct User {
    std::int32_t facet;
    std::int8_t way;  // 1: runs the edge from its lower vertex
  };

  bool Out(std::int32_t f) const { return result_.turn[f] == 0; }

  void LeaveOutCollapsed() {
    for (std::int32_t f = 0; f < count_; ++f) {
      const auto& [a, b, c] = faces_[f];
      if (a == b || b == c || c == a) LeaveOut(f);
    }
  }

  void LeaveOut(std::int32_t f) {
    result_.turn[f] = 0;
    result_.collapsed.push_back(f);
  }

  // Of each set of three vertices the first facet stays, with how the others agree with it.
  void LeaveOutDuplicates() {
    if (mesh_.defects().duplicate_facets.empty()) return;
    std::vector<std::pair<CollisionMesh::Triple, std::int32_t>> sorted;
    for (std::int32_t f = 0; f < count_; ++f) {
      if (Out(f)) continue;
      CollisionMesh::Triple v = faces_[f];
      std::ranges::sort(v);
      sorted.emplace_back(v, f);
    }
    std::ranges::sort(sorted);
    for (std::size_t i = 0; i < sorted.size();) {
      const std::int32_t kept = sorted[i].second;
      std::size_t j = i + 1;
      for (; j < sorted.size() && sorted[j].first == sorted[i].first; ++j) {
        const std::int32_t other = sorted[j].second;
        agreement_[kept] += Even(faces_[kept], faces_[other]) ? 1 : -1;
        result_.turn[other] = 0;
        result_.duplicates.push_back(other);
      }
      i = j;
    }
    std::ranges::sort(result_.duplicates);
  }

  static bool Even(const CollisionMesh::Triple& a, const CollisionMesh::Triple& b) {
    for (int k = 0; k < 3; ++k) {
      if (a[0] == b[k]) return a[1] == b[(k + 1) % 3];
    }
    return true;
  }

  void ListUsers() {
    users_.resize(mesh_.edges().size());
    for (std::int32_t f = 0; f < count_; ++f) {
      if (Out(f)) continue;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t edge = mesh_.face_edges()[f][k];
        const bool forwards = faces_[f][k] == mesh_.edges()[edge][0];
        users_[edge].push_back({f, static_cast<std::int8_t>(forwards ? 1 : -1)});
      }
    }
  }

  bool HasNoWidth(std::int32_t f) const {
    const auto& v = mesh_.vertices();
    const Vec3 a = v[faces_[f][0]], b = v[faces_[f][1]], c = v[faces_[f][2]];
    const double length = std::max({Norm(b - a), Norm(c - b), Norm(a - c)});
    const double size = std::max(Norm(mesh_.lower()), Norm(mesh_.upper()));
    return Norm(Cross(b - a, c - a)) <= kTouching * size * length;
  }

  // Facets without width at an open edge close nothing.
  void Peel() {
    std::vector<std::int32_t> waiting;
    for (std::int32_t f = count_ - 1; f >= 0; --f) {
      if (!Out(f) && HasNoWidth(f)) waiting.push_back(f);
    }
    std::vector<std::uint8_t> flat(count_, 0);
    for (const std::int32_t f : waiting) flat[f] = 1;
    while (!waiting.empty()) {
      const std::int32_t f = waiting.back();
      waiting.pop_back();
      const auto& edges = mesh_.face_edges()[f];
      const auto open = [&](std::int32_t e) { return users_[e].size() == 1; };
      if (Out(f) || !std::ranges::any_of(edges, open)) continue;
      LeaveOut(f);
      for (const std::int32_t e : edges) {
        std::erase_if(users_[e], [f](const User& user) { return user.facet == f; });
        for (const User& user : users_[e]) {
          if (flat[user.facet]) waiting.push_back(user.facet);
        }
      }
    }
    std::ranges::sort(result_.collapsed);
  }

  void FindSheets() {
    result_.sheet.assign(count_, -1);
    way_.assign(count_, 1);
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < count_; ++start) {
      if (Out(start) || result_.sheet[start] >= 0) continue;
      const std::int32_t sheet = result_.num_sheets++;
      result_.sheet[start] = sheet;
      stack.push_back(start);
      while (!stack.empty()) {
        const std::int32_t f = stack.back();
        stack.pop_back();
        for (const std::int32_t edge : mesh_.face_edges()[f]) {
          if (users_[edge].size() != 2) continue;
          const auto& [one, two] = std::tie(users_[edge][0], users_[edge][1]);
          const std::int32_t other = one.facet == f ? two.facet : one.facet;
          if (result_.sheet[other] >= 0) continue;
          result_.sheet[other] = sheet;
          way_[other] = static_cast<std::int8_t>(one.way == two.way ? -way_[f] : way_[f]);
          stack.push_back(other);
        }
      }
    }
  }

  void OrientSheets() {
    std::vector<double> vote(result_.num_sheets, 0), volume(vote);
    area_.assign(result_.num_sheets, 0);
    const Vec3 middle = 0.5 * (mesh_.lower() + mesh_.upper());
    for (std::int32_t f = 0; f < count_; ++f) {
      if (Out(f)) continue;
      const auto& v = mesh_.vertices();
      const Vec3 a = v[faces_[f][0]], b = v[faces_[f][1]], c = v[faces_[f][2]];
      const Vec3 n = Cross(b - a, c - a);
      const int given = (agreement_[f] > 0) - (agreement_[f] < 0);
      vote[result_.sheet[f]] += way_[f] * given * Norm(n);
      area_[result_.sheet[f]] += Norm(n);
      volume[result_.sheet[f]] += way_[f] * Dot(a - middle, n);
    }
    choice_.assign(result_.num_sheets, 1);
    order_.resize(result_.num_sheets);
    for (std::int32_t s = 0; s < result_.num_sheets; ++s) {
      order_[s] = s;
      if (vote[s] < 0 || (vote[s] == 0 && volume[s] < 0)) choice_[s] = -1;
    }
    for (std::int32_t f = 0; f < count_; ++f) {
      if (!Out(f)) way_[f] = static_cast<std::int8_t>(way_[f] * choice_[result_.sheet[f]]);
    }
    // Sheets given both ways are the first to go, then the small ones.
    std::ranges::stable_sort(order_, [&](std::int32_t a, std::int32_t b) {
      return std::pair(vote[a] != 0, area_[a]) < std::pair(vote[b] != 0, area_[b]);
    });
    choice_.assign(result_.num_sheets, 1);  // from here on: 1, 0 or -1 times way_
  }

  int Imbalance(std::int32_t edge) const {
    int sum = 0;
    for (const User& user : users_[edge]) {
      sum += user.way * way_[user.facet] * choice_[result_.sheet[user.facet]];
    }
    return std::abs(sum);
  }

  void ChooseSheets() {
    std::vector<std::vector<std::int32_t>> rims(result_.num_sheets);
    result_.sheet_branches.assign(result_.num_sheets, 0);
    for (std::size_t e = 0; e < users_.size(); ++e) {
      if (users_[e].size() < 3) continue;
      for (const User& user : users_[e]) {
        auto& rim = rims[result_.sheet[user.facet]];
        if (rim.empty() || rim.back() != static_cast<std::int32_t>(e)) {
          rim.push_back(static_cast<std::int32_t>(e));
        }
        result_.sheet_branches[result_.sheet[user.facet]] = 1;
      }
    }
    // What is most of its cluster is never given up, however flawed.
    std::vector<std::int32_t> cluster_of(result_.num_sheets, 0);
    for (std::int32_t f = 0; f < count_; ++f) {
      if (result_.sheet[f] >= 0) cluster_of[result_.sheet[f]] = result_.cluster[f];
    }
    std::vector<double> cluster_area(result_.num_clusters, 0), area_around(result_.num_sheets);
    for (std::int32_t s = 0; s < result_.num_sheets; ++s) cluster_area[cluster_of[s]] += area_[s];
    for (std::int32_t s = 0; s < result_.num_sheets; ++s) {
      area_around[s] = cluster_area[cluster_of[s]];
    }
    for (int round = 0; round < kRounds; ++round) {
      bool better = false;
      for (const std::int32_t s : order_) {
        if (rims[s].empty()) continue;
        const std::int8_t now = choice_[s];
        std::int8_t best = now;
        double least = Unrest(s, rims[s], now);
        for (const std::int8_t other : {1, 0, -1}) {
          if (other == 0 && !(area_[s] <= 0.5 * area_around[s])) continue;
          const double unrest = Unrest(s, rims[s], other);
          if (unrest < least) least = unrest, best = other;
        }
        choice_[s] = best;
        better |= best != now;
      }
      if (!better) break;
    }
    for (std::int32_t f = 0; f < count_; ++f) {
      if (!Out(f)) {
        result_.turn[f] = static_cast<std::int8_t>(way_[f] * choice_[result_.sheet[f]]);
      }
    }
  }

  double Unrest(std::int32_t sheet, const std::vector<std::int32_t>& rim, std::int8_t choice) {
    choice_[sheet] = choice;
    double sum = 0;
    for (const std::int32_t e : rim) {
      const auto [a, b] = mesh_.edges()[e];
      sum += Imbalance(e) * Norm(mesh_.vertices()[b] - mesh_.vertices()[a]);
    }
    return sum;
  }

  void FindClusters() {
    std::vector<std::int32_t> parent(result_.num_sheets);
    for (std::int32_t s = 0; s < result_.num_sheets; ++s) parent[s] = s;
    const auto root = [&](std::int32_t s) {
      while (parent[s] != s) s = parent[s] = parent[parent[s]];
      return s;
    };
    for (const auto& users : users_) {
      for (std::size_t i = 1; i < users.size(); ++i) {
        const auto a = root(result_.sheet[users[0].facet]), b = root(result_.sheet[users[i].facet]);
        parent[std::max(a, b)] = std::min(a, b);
      }
    }
    std::vector<std::int32_t> number(result_.num_sheets, -1);
    result_.cluster.assign(count_, -1);
    for (std::int32_t f = 0; f < count_; ++f) {
      if (result_.sheet[f] < 0) continue;
      std::int32_t& cluster = number[root(result_.sheet[f])];
      if (cluster < 0) cluster = result_.num_clusters++;
      result_.cluster[f] = cluster;
    }
  }

  const CollisionMesh& mesh_;
  const std::vector<CollisionMesh::Triple>& faces_;
  const std::int32_t count_;
  Winding result_;
  std::vector<int> agreement_;            // copies wound alike less those wound the other way
  std::vector<std::vector<User>> users_;  // of each edge: the facets that are left
  std::vector<std::int8_t> way_;          // of each facet within its sheet
  std::vector<std::int8_t> choice_;       // of each sheet
  std::vector<double> area_;              // likewise, twice
  std::vector<std::int32_t> order_;       // in which sheets are given up
};

}  // namespace

Winding FindWinding(const CollisionMesh& mesh) { return Finder(mesh).Find(); }

}  // namespace contact_toolkit
