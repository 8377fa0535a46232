// Copying and pickling of immutable objects.
#pragma once

#include <nanobind/nanobind.h>

#include <stdexcept>
#include <string>

#include "base/archive.h"

namespace contact_toolkit {

namespace nb = nanobind;

// They are their own copies: a simulator may copy the values that hold them for free.
template <typename C>
void CopiesAreTheObject(C& bound) {
  bound.def("__copy__", [](nb::handle self) { return nb::borrow(self); });
  bound.def(
      "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); },
      nb::arg("memo"));
}

// Pickled by their fields (base/archive.h), with the same bits. `finish` takes what was loaded.
template <typename T, typename Finish>
void PicklesAs(nb::class_<T>& bound, const std::string& name, Finish finish) {
  // To be raised when what is saved of any of them changes.
  const std::string mark = "contact_toolkit." + name + " 1\n";
  bound.def("__getstate__", [mark](const T& self) {
    Packer packer;
    packer(self);
    const std::string bytes = mark + packer.bytes();
    return nb::bytes(bytes.data(), bytes.size());
  });
  bound.def("__setstate__", [mark, name, finish](T& self, const nb::bytes& state) {
    const std::string_view bytes(static_cast<const char*>(state.data()), state.size());
    try {
      if (!bytes.starts_with(mark)) throw std::invalid_argument("they begin otherwise");
      Unpacker unpacker(bytes.substr(mark.size()));
      T loaded;
      unpacker(loaded);
      if (!unpacker.done()) throw std::invalid_argument("there are too many");
      finish(&loaded);
      new (&self) T(std::move(loaded));
    } catch (const std::invalid_argument& error) {
      throw nb::value_error(("these are not the bytes of a " + name +
                             " as this version saves it (" + error.what() +
                             "); make it anew, or load it with the version that "
                             "saved it")
                                .c_str());
    }
  });
}
template <typename T>
void PicklesAs(nb::class_<T>& bound, const std::string& name) {
  PicklesAs(bound, name, [](T*) {});
}

}  // namespace contact_toolkit
