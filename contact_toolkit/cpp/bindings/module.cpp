// The Python module contact_toolkit._core.
//
// Each other file in this folder binds one C++ header and defines one function,
// void BindXxx(nanobind::module_& m). Declare it here and call it below.

#include <nanobind/nanobind.h>

namespace contact_toolkit {
void BindArea(nanobind::module_& m);
void BindContact(nanobind::module_& m);
void BindContactResults(nanobind::module_& m);
void BindConvex(nanobind::module_& m);
void BindFacetPair(nanobind::module_& m);
void BindFloatingBodies(nanobind::module_& m);
void BindMesh(nanobind::module_& m);
void BindPoint(nanobind::module_& m);
void BindPoses(nanobind::module_& m);
void BindStep(nanobind::module_& m);
void BindSwept(nanobind::module_& m);
void BindWitness(nanobind::module_& m);
}  // namespace contact_toolkit

NB_MODULE(_core, m) {
  m.doc() = "The native core of the contact toolkit.";
  // pydrake before 1.52 keeps systems written in Python, and what they hold, until the process
  // ends.
  nanobind::set_leak_warnings(false);
  contact_toolkit::BindMesh(m);
  contact_toolkit::BindContactResults(m);
  contact_toolkit::BindContact(m);  // before the webs, which derive from SpringWeb
  contact_toolkit::BindArea(m);
  contact_toolkit::BindWitness(m);
  contact_toolkit::BindFacetPair(m);
  contact_toolkit::BindPoint(m);
  contact_toolkit::BindFloatingBodies(m);
  contact_toolkit::BindConvex(m);
  contact_toolkit::BindPoses(m);
  contact_toolkit::BindStep(m);
  contact_toolkit::BindSwept(m);
}
