// The tolerances of the queries and the contact law, with unit, reason and what breaks without
// each. Sizes and orders of search that change no answer stand where they are used; so do the
// shapes of the area web's windows and fields (AreaWeb, EdgeFillets, SmoothField), which are its
// formulation.
#pragma once

#include <cstddef>

namespace contact_toolkit {

// [m] Coordinates beyond this are refused: squared lengths must stay within single precision's
// range in the culling tests (1e15² = 1e30 < 3e38), and no machine is larger.
inline constexpr double kMaxCoordinate = 1e15;

// [m] Meshes smaller than this are refused for the same reason at the other end.
inline constexpr double kMinExtent = 1e-15;

// [-] On the orthonormality of a rotation given from outside: catches scales and shears, and lets
// through what has been rounded to single precision.
inline constexpr double kPoseTolerance = 1e-6;

// [-] Slack of the single-precision culling tests, as a fraction of the coordinates' size: a dozen
// roundings of 6e-8 each. Too small and pairs are missed.
inline constexpr double kCullingSlack = 2e-6;

// [-] ... and of bounds and limits themselves: their own roundings, 3e-7, and what a rotation that
// is right to kPoseTolerance only does to lengths. Far away it decides how many facets seem as
// close as the closest.
inline constexpr float kBoundRounding = 4e-6f;

// [-] A facet is thin when |n|² < kThinFacet · (longest edge)⁴, n the cross product of two edges:
// below it the plane through the facet is less accurate than 1e-12. The careful kernel takes over,
// and what it finds counts when planes prove it to the fraction kProven of (longest edge +
// distance), the points being farther apart than kProvenApart of that, or when an edge pierces a
// facet by more than kProven of what heights and sides over it could be; the rest is measured in
// extended precision, fifty times as slowly.
inline constexpr double kThinFacet = 1e-7;
inline constexpr double kProven = 1e-12;
inline constexpr double kProvenApart = 1e-10;

// [-] The same for the normal that culls: above it the normal is off by no more than 1e-16 / 1e-8
// of the mesh's size over the facet's length, which kCullingSlack covers.
inline constexpr double kFlatFacet = 1e-16;

// [-] Two edges are nearly parallel when sin² of their angle is below this: with dot products the
// distance is then off by more than 1e-12 / 3 of the facets' separation, and the careful kernel
// takes over.
inline constexpr double kNearlyParallel = 1e-7;

// [-] The fast kernel's distances are good to a tenth of this fraction of (longest edge +
// distance), or better, on facets that are not thin. Closest points clear of all others by that
// error are certain. The check of remembered features asks four times as much, so that what passes
// it is certain to the kernel too. It also keeps points off their features' ends by more than
// kOnFeature.
inline constexpr double kCertain = 1e-10;
inline constexpr double kCertainAgain = 4 * kCertain;

// [-] The error of a squared longest edge in single precision; and [m²] the least that has no
// greater one, as smaller numbers lose digits.
inline constexpr double kSquaredInSingle = 1e-5, kLeastSquared = 1e-30;

// [-] On well-conditioned features, the sides on which corners and feet lie are certain at this
// much less: they are errors of a dozen roundings, 1e-14, for kCertain's of distances.
inline constexpr double kFootError = 1e-4;

// [-] The worst condition of a pair of edges, or a facet, in the fast kernel: the inverse of sin²
// of their angle, or of how thin it is.
inline constexpr double kWorstCondition = 1e7;

// [-] The error of the heights that the check of remembered features takes, over the distance and
// the longest edge: it keeps the directions of edges in single precision.
inline constexpr double kSingleError = 1e-7;

// [-] Remembered features closer than this fraction of the longest edge around are measured afresh:
// below it, rounding could let nearly parallel edges at two corners win over the corners.
inline constexpr double kTooClose = 2e-5;

// [-] Features of facets smaller than this fraction of the coordinates' size are not remembered:
// the facets would not keep their shape, to within the margins above, where they are posed.
inline constexpr double kTinyFacet = 1e-7;

// [-] Candidates are worn when this fraction of them would have to be measured because they have
// changed features: some steps later that has cost as much as gathering anew.
inline constexpr double kWorn = 0.25;

// [-] Features are learnt anew when this fraction of all pairs has been measured because of changed
// features: about what learning costs beyond that of each pair learnt. But not for a few.
inline constexpr double kLearning = 0.08;
inline constexpr double kWorthLearning = 200;
// So many pairs tell whether they are certain enough to be learnt.
inline constexpr std::size_t kLearningSample = 64;
// Where it has been in vain so many times in a row, learning is put off no longer than that.
inline constexpr int kMostInVain = 8;

// [-] Candidates are worth gathering when the slack is at least this many times the last motion:
// that many queries make up for what gathering costs beyond a query from scratch.
inline constexpr double kWorthGathering = 4;

// [-] The slack of candidates is this many times the root of the widest slack times the last
// motion, but no narrower than that fraction of the widest. With gathering at a dozen coherent
// queries and candidates doubling over three times the widest slack this is the cheapest.
inline constexpr double kSlackPerRoot = 6, kNarrowest = 1.0 / 16;
// The motion is watched over that many queries, and the slack narrowed if it is that many times as
// wide as the fastest of them would have it: some such spans later this has paid.
inline constexpr int kQueriesWatched = 64;
inline constexpr double kTooWide = 2;

// [-] Two edges count as parallel when sin² of their angle is below this: treating them so moves
// the witness points apart by less than 1e-14 of the edges' lengths.
inline constexpr double kParallel = 1e-28;

// [-] A witness point within this fraction of an edge's length from its end lies on the end vertex,
// a barycentric coordinate below it puts the point on the edge. It decides features, never
// distances.
inline constexpr double kOnFeature = 1e-9;

// [-] Witness points closer than this fraction of the coordinates' size touch: their difference is
// rounding, and gives no direction.
inline constexpr double kTouching = 1e-14;

// [-] A point closer to an edge or vertex than this fraction of the mesh's size is on it: the
// direction from the closest point is then round-off, and the pseudonormal stands in.
inline constexpr double kOnSurface = 1e-13;

// [-] A body's thickness is known to this fraction: it decides which of two bodies the area web
// samples (those within 1 % count as equal) and how deep a contact may be.
inline constexpr double kThicknessTolerance = 2e-3;

// GJK. Iterations: polytopes take about ten; the limit only guards against an endless loop.
inline constexpr int kGjkIterations = 200;
// [-] It ends when distance and lower bound agree to this many roundings of the coordinates, and
// sets closer than that overlap.
inline constexpr double kGjkGap = 4;
// [-] A tetrahedron of less than this fraction of its longest edge cubed has no reliable inside:
// its faces, which are then as near, are used instead.
inline constexpr double kFlatTetrahedron = 1e-14;

// Passes of refinement of a point's weights in a tetrahedron: each leaves a hundredth of the error
// of the last even in the flattest, which starts with 1 % of its size.
inline constexpr int kWeightPasses = 6;

// Swept queries.
// Steps of conservative advancement for one pair in one slice; about ten are usual, some hundred
// where edges graze. Past the limit the answer says so and stays on the safe side.
inline constexpr int kAdvanceSteps = 10000;
// [-] A slice is halved when boxes travel further than this many times the largest of them.
inline constexpr float kLongWay = 1.5f;
// [rad] ... or when they turn further than this: a box would swell by more than a third.
inline constexpr double kWideTurn = 0.6;
// [-] Culling in single precision is useless once its slack exceeds this fraction of the facets'
// size.
inline constexpr double kCoarse = 0.1;
// [-] The direction along which nodes are culled serves until the distance has fallen by this
// fraction of itself or, as far away it hardly changes with the direction, of the smaller body's
// size.
inline constexpr double kStaleAim = 0.01;
// [-] No slice is shorter than this fraction of the motion.
inline constexpr double kShortestSlice = 1e-9;

// [-] Share of the standoff by which candidates for the facet web are gathered from farther away: a
// larger one lasts longer and costs more.
inline constexpr double kCandidateSlack = 0.25;

// [-] Share of the node spacing by which a body may move while the area web relies on what it
// remembers, for the same reason.
inline constexpr double kAreaSlack = 0.125;
// [-] For what moves little it is so many times the way moved in a step, yet at least this fraction
// of the spacing; what was gathered with a slack much larger than that is gathered anew.
inline constexpr double kSlackSteps = 32;
inline constexpr double kLeastAreaSlack = 0.008;
inline constexpr double kMuchSlack = 8;

// [-] A step that loses less than this fraction of the energy stored and lost so far is summed up
// from its ends alone: a body at rest costs nothing more.
inline constexpr double kLedgerTolerance = 1e-7;

// The implicit step.
// [-] It is solved when the residual is this fraction of what the step does without contact, or of
// the contact's own impulse: at rest under gravity a speed of 1e-10 m/s at steps of a millisecond.
inline constexpr double kStepTolerance = 1e-8;
// [-] Of the forces with which springs push against each other, in a wedge or a press fit, this
// fraction counts as what the step does.
inline constexpr double kStepSqueeze = 1e-2;
// [-] By a Newton step, if all that is left is this fraction.
inline constexpr double kStepNear = 3e-6;
// [m/s] And at least this speed: times kStepTolerance and a step it is below the rounding of poses.
inline constexpr double kStepStill = 1e-6;
// [m/s, rad/s] What moves more slowly is taken to be at rest: it came there with 1e-11.
inline constexpr double kStepAtRest = 1e-9;
// [-] Where no step lessens the residual any more, it is rounding below this fraction.
inline constexpr double kStepRoundOff = 1e-5;
// Newton iterations; three are usual, ten many. And rounds of bodies that come near on the way.
inline constexpr int kStepIterations = 60, kStepRounds = 4;
// Steps along the path to a solution that Newton's method does not find, and corrections of each; a
// dozen and two are usual.
inline constexpr int kPathSteps = 100, kPathCorrections = 6;
// [-] Where the paths start that are tried one after the other, in velocities without contact.
inline constexpr double kPathStarts[] = {1, 0};
// [-] The first such step, the longest and the shortest, as fractions of the velocities without
// contact; and how close to the path each must come, as a fraction of its length.
inline constexpr double kFirstOnPath = 0.05, kLongestOnPath = 0.1, kShortestOnPath = 1e-7;
inline constexpr double kOnPath = 1e-2;
// [-] Fraction of the decrease that the residual's slope promises which a step must bring; and the
// shortest one that is tried, as a fraction of Newton's.
inline constexpr double kStepDecrease = 1e-4, kShortestSearch = 1e-4;
// [-] How far along a direction that led nowhere contacts are looked for, as a fraction of it.
inline constexpr double kStepAhead = 0.01;

// [-] Slack of the boxes' overlap test between bodies, as a fraction of their coordinates: some
// fifty roundings. Without it a pair far from the origin could be lost by a rounding.
inline constexpr double kBoxSlack = 1e-14;

// [-] A smooth field whose gradient changes by less over a cell counts as flat there: over a plane
// its coefficients carry the rounding of distances, a thousandth of this.
constexpr double kFlatCell = 1e-9;

}  // namespace contact_toolkit
