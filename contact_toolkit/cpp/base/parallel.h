// A loop shared between threads. Iterations must not depend on each other; which thread runs which
// is not fixed, so results belong in a place of their own for each iteration.
#pragma once

#include <functional>

namespace contact_toolkit {

// Calls body(i, worker) once for every i in [0, count); worker < threads numbers the calling
// thread. One thread (or one iteration) runs in place. The first exception is rethrown here. Nested
// calls from inside a body run in place.
void ParallelFor(int count, int threads, const std::function<void(int, int)>& body);

}  // namespace contact_toolkit
