// bindings/creep_law.hpp - a creep law by the name that a configuration uses, with what it needs.
#pragma once
#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "rollerrig/contact/creep/creep_law.hpp"

/// Keeps the table alive that the law points to.
struct NamedCreepLaw {
  rollerrig::CreepLaw law;
  std::shared_ptr<rollerrig::CreepTable const> table;

  NamedCreepLaw(std::string const& name, bool saturate_spin_moment, std::array<double, 3> const& reduction,
                std::array<double, 2> const& polach, std::shared_ptr<rollerrig::CreepTable> shared)
      : table{std::move(shared)} {
    using Kind = rollerrig::CreepLawKind;
    law = {kind_of(name), saturate_spin_moment, {reduction[0], reduction[1], reduction[2]}, polach[0],
           polach[1],     table.get()};
    if (law.kind == Kind::table && !table) throw nanobind::value_error("the law 'table' needs its table");
  }

  static rollerrig::CreepLawKind kind_of(std::string const& name) {
    using Kind = rollerrig::CreepLawKind;
    if (name == "kalker_linear") return Kind::kalker_linear;
    if (name == "kalker_saturated") return Kind::kalker_saturated;
    if (name == "fastsim") return Kind::fastsim;
    if (name == "modified_fastsim") return Kind::modified_fastsim;
    if (name == "polach") return Kind::polach;
    if (name == "table") return Kind::table;
    throw nanobind::value_error(
        "unknown creep law; known: kalker_linear, kalker_saturated, fastsim, modified_fastsim, polach, table");
  }
};
