// bindings/module.cpp - the extension rollerrig._core. Bindings translate, nothing more: no formula, no default.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_contact_laws(nb::module_& m);
void bind_model(nb::module_& m);
void bind_contact(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_mechatronics(nb::module_& m);
void bind_plant(nb::module_& m);
void bind_realtime(nb::module_& m);

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // caches and fixtures of Python may outlive the module at exit
  m.doc() = "Compiled core of rollerrig: model, contact, simulation. SI units throughout.";
  bind_contact_laws(m);
  bind_model(m);
  bind_contact(m);
  bind_mechatronics(m);
  bind_simulation(m);
  bind_plant(m);
  bind_realtime(m);
}
