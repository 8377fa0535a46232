// The Python module contact_toolkit._core.
//
// Each other file in this folder binds one C++ header and defines one function,
// void bind_xxx(nanobind::module_& m). Declare it here and call it below.

#include <nanobind/nanobind.h>

NB_MODULE(_core, m) { m.doc() = "The native core of the contact toolkit."; }
