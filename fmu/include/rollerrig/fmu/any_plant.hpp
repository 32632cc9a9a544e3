// fmu/any_plant.hpp - what runs in an FMU: a whole rig, or one controller alone.
//
//   RigPlant, ControllerPlant -> [AnyPlant] -> Instance
#pragma once
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "rollerrig/plant/continuous_plant.hpp"
#include "rollerrig/plant/controller_plant.hpp"
#include "rollerrig/plant/plant.hpp"

namespace rollerrig::fmu {

/// A plant that knows the model as it came, whatever parameters it has been given since.
class RigPlant : public Plant {
 public:
  explicit RigPlant(AssembledModel assembled) : Plant{assembled}, original_{std::move(assembled)} {}
  AssembledModel const& original() const { return original_; }

 private:
  AssembledModel original_;
};

class AnyPlant {
  // In front of its callers, which are to know its type.
  template <class Self, class Question>
  static auto ask(Self& self, Question question) {
    return self.rig_ ? question(*self.rig_) : question(*self.controller_);
  }

 public:
  explicit AnyPlant(AssembledModel assembled) : rig_{std::make_unique<RigPlant>(std::move(assembled))} {}
  explicit AnyPlant(ControllerPart part) : controller_{std::make_unique<ControllerPlant>(std::move(part))} {}

  /// Null where it is a controller alone.
  RigPlant* rig() { return rig_.get(); }
  /// Whether another program can integrate it: a controller alone has no such states.
  bool exchangeable() const { return rig_ != nullptr; }
  /// For model exchange; null of a controller alone, or where no run has begun.
  ContinuousPlant* continuous() {
    if (exchangeable() && rig_->started() && !continuous_) continuous_ = std::make_unique<ContinuousPlant>(*rig_);
    return continuous_.get();
  }

  std::span<Variable const> variables() const {
    return ask(*this, [](auto const& p) { return std::span<Variable const>(p.variables()); });
  }
  Status start(double final_time) {
    continuous_.reset();
    return ask(*this, [&](auto& p) { return p.start(final_time); });
  }
  Status advance(double time) {
    continuous_.reset();
    return ask(*this, [&](auto& p) { return p.advance(time); });
  }
  bool set_input(int index, double value) {
    bool const done = ask(*this, [&](auto& p) { return p.set_input(index, value); });
    if (continuous_) continuous_->forget();
    return done;
  }
  bool set_parameter(int index, double value) {
    return ask(*this, [&](auto& p) { return p.set_parameter(index, value); });
  }
  double get(int index) {
    return ask(*this, [&](auto& p) { return p.get(index); });
  }
  std::vector<std::byte> save() {
    return ask(*this, [](auto& p) { return p.save(); });
  }
  bool restore(std::span<std::byte const> bytes) {
    continuous_.reset();
    return ask(*this, [&](auto& p) { return p.restore(bytes); });
  }
  double time() const {
    return ask(*this, [](auto const& p) { return p.time(); });
  }
  std::string_view failed_wheel() const {
    if (continuous_) return continuous_->failed_wheel();
    return ask(*this, [](auto const& p) { return p.failed_wheel(); });
  }

  /// A plant of the same model, as it was before its first run.
  friend std::unique_ptr<AnyPlant> anew(AnyPlant const& plant) {
    return plant.rig_ ? std::make_unique<AnyPlant>(plant.rig_->original())
                      : std::make_unique<AnyPlant>(plant.controller_->part());
  }

 private:
  std::unique_ptr<RigPlant> rig_;
  std::unique_ptr<ContinuousPlant> continuous_;  ///< of it
  std::unique_ptr<ControllerPlant> controller_;
};

}  // namespace rollerrig::fmu
