#include "rollerrig/plant/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "rollerrig/system/equilibrium.hpp"

namespace rollerrig {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr char const* directions[] = {"x", "y", "z", "roll", "pitch", "yaw"};

std::string words(std::string text) {
  std::ranges::replace(text, '_', ' ');
  return text;
}

template <class V>
struct IsVariant : std::false_type {};
template <class... Laws>
struct IsVariant<std::variant<Laws...>> : std::true_type {};

/// Laws of the rig's controller go by their numbers at every sample; a Kalman filter has a gain that it found at its start.
template <class V>
constexpr bool sampled_laws = std::is_same_v<V, AnyEstimator> || std::is_same_v<V, AnyAxleTorque> ||
                              std::is_same_v<V, AnyFeedback> || std::is_same_v<V, AnyDriveCommand>;
template <class Law>
constexpr bool settled_at_start = requires { requires Law::settled_at_start; };

}  // namespace

/// Collects the numbers of one model.
struct ModelParameters::Walk {
  ModelParameters& own;

  void add(std::string name, std::string_view unit, std::string what, Range const& range, std::vector<double*> places,
           bool fixed = true) {
    auto const limit = [](double number) { return std::abs(number) < 1e59 ? number : std::copysign(endless, number); };
    double const value = *places.front(), most = limit(range.highest);
    own.variables_.push_back({std::move(name), std::string(unit), std::move(what), Causality::parameter,
                              fixed ? Variability::fixed : Variability::tunable, value,
                              range.magnitude ? -most : range.lowest, most});
    own.place_.push_back(std::move(places));
    own.first_.push_back(value);
  }

  /// Every number of a struct and of the structs and laws in it that acts on something.
  template <Described S>
  void fields(S& s, std::string const& owner, bool fixed) {
    static_assert(every_number_has_a_unit<S>);
    auto const one = [&](auto const& field) {
      auto& value = s.*field.member;
      using V = std::remove_cvref_t<decltype(value)>;
      std::string_view const name = field.name;
      if (name.starts_with("sand") && !(own.setup_ && own.setup_->sanding)) return;
      if constexpr (std::is_same_v<V, VirtualRail>) return;  // what it is follows from the case
      if constexpr (std::is_same_v<S, Friction>)
        if (name == "gauge_face" ? s.gauge_face < 0.0 : s.map != nullptr) return;
      std::string const inner = name == "law" || std::is_same_v<V, FrictionLaw> ? owner : owner + "." + field.name;
      auto const number = [&](double& of) { add(inner, field.unit, field.meaning, field.range, {&of}, fixed); };
      if constexpr (std::is_same_v<V, double>) {
        number(value);
      } else if constexpr (requires { value.has_value(); }) {
        if (!value) return;
        if constexpr (Described<typename V::value_type>)
          fields(*value, inner, fixed);
        else
          number(*value);
      } else if constexpr (Described<V>) {
        fields(value, inner, fixed);
      } else if constexpr (IsVariant<V>::value) {
        std::visit(
            [&]<class Law>(Law& law) { fields(law, inner, fixed && !(sampled_laws<V> && !settled_at_start<Law>)); },
            value);
      }
    };
    S::fields()([&](auto const&... field) { (one(field), ...); });
  }

  /// What acts: a body that is held has no mass of its own here, one that only spins a single moment of inertia.
  void bodies() {
    for (std::size_t i = 0; i < own.parts_.bodies.size(); ++i) {
      Body& body = own.parts_.bodies[i];
      std::string const& name = own.given_.names.bodies[i];
      auto const& locked = body.locked;
      bool const moves = !(locked[coord_x] && locked[coord_y] && locked[coord_z]);
      bool const tilts = !(locked[coord_roll] && locked[coord_yaw]), spins = !locked[coord_pitch];
      if (moves) add(name + ".mass", "kg", "mass of " + words(name), positive, {&body.mass});
      if (tilts)
        add(name + ".inertia_x", "kg m^2", "moment of inertia of " + words(name) + " in roll", positive,
            {&body.inertia.x});
      if (tilts || spins)
        add(name + ".inertia_y", "kg m^2", "moment of inertia of " + words(name) + " in pitch", positive,
            {&body.inertia.y});
      if (tilts)
        add(name + ".inertia_z", "kg m^2", "moment of inertia of " + words(name) + " in yaw", positive,
            {&body.inertia.z});
    }
  }

  /// Linear springs and dampers.
  void elements() {
    for (std::size_t i = 0; i < own.parts_.elements.size(); ++i)
      for (std::size_t c = 0; c < std::size(directions); ++c) {
        std::string const name = own.given_.names.elements[i] + "." + directions[c];
        char const* const force = c < 3 ? "N" : "N m";
        char const* const path = c < 3 ? "m" : "rad";
        auto const number = [&](double& value, char const* field, std::string const& unit) {
          add(name + "_" + field, unit,
              words(std::string(field) + " of " + own.given_.names.elements[i] + " in ") + directions[c], not_negative,
              {&value});
        };
        for (ForceLaw& law : own.parts_.elements[i].law[c].laws) {
          if (auto* spring = std::get_if<LinearSpring>(&law))
            number(spring->stiffness, "stiffness", std::string(force) + "/" + path);
          if (auto* damper = std::get_if<LinearDamper>(&law))
            number(damper->damping, "damping", std::string(force) + " s/" + path);
          if (auto* damper = std::get_if<SeriesDamper>(&law)) {
            number(damper->damping, "damper_damping", std::string(force) + " s/" + path);
            number(damper->series_stiffness, "damper_stiffness", std::string(force) + "/" + path);
          }
        }
      }
  }

  void friction() {
    for (std::size_t i = 0; i < own.parts_.described_contacts.size(); ++i)
      fields(own.parts_.described_contacts[i].friction,
             wheel_name(own.given_, own.given_.model->contacts[i]) + ".friction", true);
  }

  /// A map of its own in place of each one that contacts and virtual rails share.
  void adhesion() {
    std::map<AdhesionMap const*, std::shared_ptr<AdhesionMap>> copies;
    auto const replace = [&](Friction& friction) {
      if (!friction.map) return;
      auto& copy = copies[friction.map.get()];
      if (!copy) own.maps_.push_back(copy = std::make_shared<AdhesionMap>(*friction.map));
      friction.map = copy;
    };
    for (ContactDescription& contact : own.parts_.described_contacts) replace(contact.friction);
    if (own.setup_) {
      if (own.setup_->rail) replace(own.setup_->rail->friction);
      for (SampledController& one : own.setup_->controllers)
        if (auto* rig = std::get_if<RigController>(&one.controller)) replace(rig->rail.friction);
    }
    for (std::size_t m = 0; m < own.maps_.size(); ++m)
      for (std::size_t k = 0; k < own.maps_[m]->pieces.size(); ++k) {
        std::string const map = own.maps_.size() > 1 ? "adhesion_" + std::to_string(m + 1) : "adhesion";
        std::string const piece = own.maps_[m]->pieces.size() > 1 ? ".piece_" + std::to_string(k + 1) : "";
        fields(own.maps_[m]->pieces[k], map + piece, true);
      }
  }

  /// What is sampled, and the brake unit where it is not.
  void controllers() {
    for (SampledController& one : own.setup_->controllers)
      std::visit(
          [&]<class Law>(Law& law) {
            fields(law, Law::name, std::is_same_v<Law, RigController> || std::is_same_v<Law, BrakeUnit>);
          },
          one.controller);
    if (own.setup_->braked() && !own.setup_->brake_unit_is_sampled())
      fields(own.setup_->actuators.pneumatics, "brake", true);
  }

  /// Of all rollers: their crowns stay where they are.
  void rollers() {
    std::vector<double*> radius;
    for (ContactDescription& contact : own.parts_.described_contacts)
      if (contact.roller_radius > 0.0) radius.push_back(&contact.roller_radius);
    if (radius.empty() || std::ranges::any_of(radius, [&](double const* one) { return *one != *radius.front(); }))
      return;
    add("rollers.radius", "m", "radius of the rollers at their crowns", positive, std::move(radius));
  }
};

ModelParameters::ModelParameters(AssembledModel const& assembled)
    : given_{assembled}, parts_{*assembled.model}, setup_{assembled.setup} {
  Walk walk{*this};
  walk.bodies();
  walk.elements();
  walk.friction();
  walk.adhesion();
  walk.rollers();
  if (setup_) walk.controllers();
}

void ModelParameters::set(std::size_t index, double value) {
  for (double* place : place_[index]) *place = value;
}

AssembledModel ModelParameters::assembled() const {
  bool changed = false;
  for (std::size_t i = 0; i < variables_.size(); ++i)
    changed = changed || (variables_[i].variability == Variability::fixed && get(i) != first_[i]);
  AssembledModel out = given_;
  if (setup_) out.setup->controllers = setup_->controllers;
  if (!changed) return out;
  ModelParts parts = parts_;
  for (ContactDescription const& contact : parts.described_contacts) {
    if (!(contact.roller_radius > 0.0)) continue;
    Body& roller = parts.bodies[at(contact.roller)];
    roller.position.z = -contact.roller_radius;
    if (roller.speed_controlled()) roller.speed_controlled_radius = contact.roller_radius;
  }
  out.setup = setup_;
  out.model = model_of(parts);
  auto start = starting_state(out.model, out.start_time, out.disturbances);
  if (start.found == StartingState::no_equilibrium)
    throw std::invalid_argument("parameters: the model has no equilibrium with them");
  if (start.found == StartingState::no_support)
    throw std::invalid_argument("parameters: " + out.names.bodies[at(start.body)] +
                                " finds no support at its disturbance with them");
  out.start = std::move(start.x);
  return out;
}

}  // namespace rollerrig
