// Memory that a place in the code keeps between calls, one for each thread, so that nothing is
// allocated in the steady state.
#pragma once

namespace contact_toolkit {

// `place` is a lambda written at the call, whose type makes it a place of its own:
//   MergeTable& table = Scratch<MergeTable>([] {});
// In a shared library each look at a thread_local variable is a function call. Not inlined, this is
// the only one; the compiler would otherwise repeat it rather than keep the address.
template <class T, class Place>
[[gnu::noinline]] T& Scratch(Place /*place*/) {
  thread_local T memory;
  return memory;
}

}  // namespace contact_toolkit
