#include "contact/stretch_exchange.h"

#include <algorithm>

namespace contact_toolkit {
namespace {

bool ShareVertex(const std::array<std::int32_t, 3>& a, const std::array<std::int32_t, 3>& b) {
  return std::ranges::any_of(
      a, [&b](std::int32_t v) { return v >= 0 && std::ranges::find(b, v) != b.end(); });
}

}  // namespace

StretchExchange::StretchExchange(const SpringWeb& web, const AnchorSet& anchors,
                                 const std::vector<double>& kept)
    : web_(web) {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Anchor& anchor = anchors.anchors()[i];
    if (!(anchor.stiffness > kept[i])) continue;
    const auto offer = static_cast<std::int32_t>(offers_.size());
    offers_.push_back({&anchor, anchor.stiffness - kept[i], web.VerticesOf(anchor.key)});
    for (const std::int32_t vertex : offers_.back().vertices.of_a) {
      if (vertex >= 0) by_vertex_.push_back({vertex, offer});
    }
  }
  std::ranges::sort(by_vertex_);
}

const std::vector<StretchExchange::Share>& StretchExchange::Take(std::uint64_t key, double wanted) {
  taken_.clear();
  const FeatureVertices vertices = web_.VerticesOf(key);
  for (const std::int32_t vertex : vertices.of_a) {
    if (vertex < 0) continue;
    auto it = std::ranges::lower_bound(by_vertex_, std::pair{vertex, std::int32_t{0}});
    for (; it != by_vertex_.end() && it->first == vertex; ++it) {
      Offer& offer = offers_[it->second];
      const double share = std::min(wanted, offer.stiffness);
      if (!(share > 0) || !ShareVertex(offer.vertices.of_b, vertices.of_b)) continue;
      offer.stiffness -= share;
      wanted -= share;
      taken_.push_back({offer.anchor, share});
    }
  }
  return taken_;
}

}  // namespace contact_toolkit
