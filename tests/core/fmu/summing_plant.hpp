// tests/core/fmu/summing_plant.hpp - a plant for the FMU's shell that needs no rig: an output is the integral of an input.
#pragma once
#include <string>
#include <vector>

#include "rollerrig/fmu/instance.hpp"

namespace rollerrig::test {

class SummingPlant : public AnyPlant {
 public:
  std::span<Variable const> variables() const override { return variables_; }
  Status start(double final_time) override {
    end = final_time;
    started_ = true;
    time_ = sum_ = 0.0;
    rate_ = variables_[0].start;
    status_ = Status::ok;
    return starts;
  }
  Status advance(double t) override {
    double const reached = std::min(t, fails_at);
    sum_ += rate_ * (reached - time_);
    time_ = reached;
    return status_ = t > fails_at ? Status::derailed : status_;
  }
  bool set_input(int index, double value) override {
    rate_ = index == 0 ? value : rate_;
    return index == 0;
  }
  bool set_parameter(int index, double value) override {
    bool const may = index == 2 && !started_;
    mass_ = may ? value : mass_;
    return may;
  }
  std::vector<std::byte> save() override { return {std::byte{1}}; }
  bool restore(std::span<std::byte const> bytes) override { return bytes.size() == 1; }
  double get(int index) override { return index == 1 ? sum_ : index == 0 ? rate_ : mass_; }
  double time() const override { return time_; }
  std::string_view failed_wheel() const override { return status_ == Status::derailed ? "wheelset_1_left" : ""; }

  std::unique_ptr<AnyPlant> anew() const override { return std::make_unique<SummingPlant>(); }

  double fails_at{1e300}, end{};
  Status starts{Status::ok};

 private:
  std::vector<Variable> variables_{{"rate", "1/s", "", Causality::input, Variability::discrete, 2.0, -10.0, 10.0, true},
                                   {"sum", "1", "", Causality::output, Variability::continuous, 0.0, -1.0, 1.0},
                                   {"mass", "kg", "", Causality::parameter, Variability::fixed, 7.0, 0.0, 1e3}};
  double time_{}, sum_{}, rate_{}, mass_{7.0};
  bool started_{false};
  Status status_{};
};

}  // namespace rollerrig::test
