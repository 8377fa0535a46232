// The area web: an elastic foundation between two bodies. The surface of one (sampled) carries
// nodes, each probes the signed distance phi of the other (probed); the deformation d = standoff -
// phi is taken as linear between nodes and integrated in closed form over the part of the surface
// where it is positive. Node i has the elastic force K I_i along the gradient of phi: together the
// exact gradient of the stored energy. K is a pressure per deformation [Pa/mⁿ], so the answer does
// not depend on either mesh.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "web/area/area_body.h"
#include "web/area/area_grounds.h"
#include "web/area/edge_fillets.h"
#include "web/spring_web.h"

namespace contact_toolkit {

struct AreaCandidates;
struct AreaMemory;

enum class AreaField {
  kExact,  // the distance itself; its gradient jumps where the closest facet changes
  // SmoothField: continuous forces, at a tenth of the time; convex edges slightly rounded. In a
  // thin shell about an open surface, which would take very many cells, the exact one.
  kSmooth,
};
enum class AreaSide { kAuto, kA, kB };

struct AreaWebOptions {
  double stiffness = 0;  // [Pa/mⁿ] K
  double exponent = 1;   // n
  double standoff = 0;   // [m] a shell about the probed body; one without an inside needs it
  AreaField field = AreaField::kSmooth;
  // Node spacing, as a fraction of the smaller bounding box's diagonal. Negative: 0.02, or as much
  // less as a round probed body needs under the nominal force.
  double resolution = -1;
  AreaSide sampled = AreaSide::kAuto;
  double fillet = 0;         // [m] radius of the bodies' sharp edges, see EdgeFillets; 0: none
  double nominal_force = 0;  // [N] that the contact usually bears; 0: the smaller body's weight
                             // were it water
};

class AreaWeb final : public SpringWeb {
 public:
  // By default the smaller body is sampled: it moves on the other as a rule, and nodes that come
  // and go at its rim would brake it. A much flatter one is probed, where the distance is exact and
  // its pieces linear, above all by capsules and cylinders, whose lattice has few nodes where they
  // lie on it. Before that, a much thinner one is sampled: a deep contact would push the
  // other out of its wrong side. Bodies within 1 %: the one of more facets, then A. One without an
  // inside is sampled unless both are without, a round one only if both are. Throws
  // std::invalid_argument naming the option and the mend.
  AreaWeb(std::shared_ptr<const AreaBody> A, std::shared_ptr<const AreaBody> B,
          const AreaWebOptions& options);

  // Keys name nodes. `deformation` is that of the node itself: slightly negative where only part of
  // its facets is loaded. Whichever body is sampled, rows speak of A and B as SpringSet says.
  void FindSprings(const Pose& X_AB, SpringSet* springs) const override;

  bool RecallSprings(const WebMemory& memory, const Pose& X_AB, SpringSet* springs) const override;

  std::shared_ptr<const WebMemory> LookAround(const SpringSet& last_springs, const Pose& last_X_AB,
                                              const Pose& X_AB) const override;

  std::shared_ptr<const WebMemory> Remember(const SpringSet& springs, const Pose& last_X_AB,
                                            const Pose& X_AB,
                                            std::shared_ptr<const WebMemory> before) const override;

  double Clearance(const Pose& X_AB, double enough) const override;

  double reach() const override;

  bool samples_a() const { return samples_a_; }
  double spacing() const { return spacing_; }
  double cell() const { return cell_; }  // [m] of the smooth field; 0 with the exact one
  // [m] Deeper than this a node no longer knows the way out; infinite for an open probed body.
  double capture_depth() const { return capture_depth_; }

 private:
  template <typename Probe>
  class Loader;

  // Of the sampled body in the probed one.
  Pose PoseOfSampled(const Pose& X_AB) const;
  template <typename Function>
  auto WithProbe(const Function& function) const;
  template <typename Probe, typename Way>
  void Gather(const Pose& X_PS, const Way& way, Probe* probe, AreaCandidates* candidates) const;
  // In the sampled body, about springs found at a pose.
  Sphere Around(const SpringSet& springs, const Pose& X_AB) const;
  // [m] Little for what moves little.
  double SlackFor(double moved) const;
  std::shared_ptr<const AreaMemory> GatherNear(const Pose& X_PS, const Sphere& around,
                                               double slack) const;
  template <typename Probe>
  void GatherNear(Probe* probe, AreaMemory* memory) const;

  AreaWebOptions options_;
  bool samples_a_;
  double spacing_, cell_ = 0, capture_depth_;
  // A round body bulges between nodes: by this times the sum of a triangle's squared edges [1/m],
  // and nowhere by more than so much [m].
  double bulge_ = 0, most_bulge_ = 0;
  double rise_ = 0;      // [m] by which the sampled surface stands out of its mesh
  double overhang_ = 0;  // [m] by which the probed surface stands out of its mesh
  std::shared_ptr<const CollisionMesh> sampled_;
  std::shared_ptr<const ProbedSurface> surface_;
  std::shared_ptr<const AreaNodes> nodes_;
  std::shared_ptr<const DistanceBounds> bounds_;
  AreaGrounds grounds_;
  std::shared_ptr<const SmoothField> smooth_;   // null with the exact field
  std::unique_ptr<const EdgeFillets> fillets_;  // null without
};

}  // namespace contact_toolkit
