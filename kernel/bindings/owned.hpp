// What Python holds, and who may change it at the moment.
#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/controller.hpp"
#include "plants/plant.hpp"

namespace rcac {

// Taken while an object moves: a function of the user that a step calls, and any other thread,
// would find it half-way and is refused.
class InUse {
public:
    explicit InUse(const char* name) : name_(name) {}
    void take() {
        if (taken_.exchange(true, std::memory_order_acquire))
            throw std::invalid_argument(std::string("the ") + name_ + " is in the middle of a step");
    }
    void release() { taken_.store(false, std::memory_order_release); }

private:
    const char* name_;
    std::atomic<bool> taken_{false};
};

// Takes objects and gives them back at its end.
class Hold {
public:
    Hold() = default;
    explicit Hold(InUse& use) : one_(&use) { use.take(); }
    Hold(const Hold&) = delete;
    ~Hold() {
        if (one_) one_->release();
        for (InUse* use : more_) use->release();
    }
    void add(InUse& use) {
        more_.push_back(&use);
        try {
            use.take();
        } catch (...) {
            more_.pop_back();
            throw;
        }
    }

private:
    InUse* one_ = nullptr;
    std::vector<InUse*> more_;
};

struct OwnedController {
    OwnedController(ControllerPlan plan, std::unique_ptr<Update> update, std::vector<double> theta)
        : controller(std::move(plan), std::move(update), std::move(theta)) {}
    void visit(Archive& archive) { controller.visit(archive); }
    Controller controller;
    InUse use{"controller"};
};

struct OwnedPlant {
    explicit OwnedPlant(std::unique_ptr<Plant> made) : plant(std::move(made)) {}
    std::unique_ptr<Plant> plant;
    InUse use{"plant"};
};

// Puts a saved state into an object, which stays as it was where the state does not fit.
template <class Object>
void restore(Object& object, std::vector<double> state) {
    Archive before, archive(std::move(state));
    object.visit(before);
    try {
        object.visit(archive);
        archive.finish();
    } catch (...) {
        Archive back(before.values());
        object.visit(back);
        throw;
    }
}

}  // namespace rcac
