// Saving and restoring what a run carries from step to step, bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace rcac {

// A class with a state lists it once, in `visit(Archive&)`; whether that writes or reads is the
// archive's business. The layout is a flat vector of doubles; integers travel as their bits.
class Archive {
public:
    Archive() = default;                                                 // writes
    explicit Archive(std::vector<double> values) : values_(std::move(values)), reading_(true) {}

    static constexpr std::int64_t longest = std::int64_t{1} << 62;  // of any count of steps

    bool reading() const { return reading_; }

    void operator()(double& value) {
        if (!reading_) {
            values_.push_back(value);
        } else {
            if (position_ >= values_.size()) wrong_size();
            value = values_[position_++];
        }
    }
    void operator()(std::int64_t& value) {
        double bits;
        std::memcpy(&bits, &value, sizeof bits);
        (*this)(bits);
        std::memcpy(&value, &bits, sizeof bits);
    }
    // A count or an index that something is reached by, in [least, most].
    void operator()(std::int64_t& value, std::int64_t least, std::int64_t most) {
        (*this)(value);
        if (reading_ && (value < least || value > most))
            throw std::invalid_argument("it holds " + std::to_string(value) + " where a number from " +
                                        std::to_string(least) + " to " + std::to_string(most) +
                                        " belongs");
    }
    void operator()(bool& value) {
        std::int64_t number = value;
        (*this)(number);
        value = number != 0;
    }
    void operator()(double* values, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) (*this)(values[i]);
    }
    // The size must be that of the object which is being restored.
    void operator()(std::vector<double>& values) { (*this)(values.data(), values.size()); }

    const std::vector<double>& values() const { return values_; }
    void finish() const {
        if (reading_ && position_ != values_.size()) wrong_size();
    }

private:
    [[noreturn]] void wrong_size() const {
        throw std::invalid_argument("the state holds " + std::to_string(values_.size()) +
                                    " numbers, which does not fit");
    }
    std::vector<double> values_;
    std::size_t position_ = 0;
    bool reading_ = false;
};

}  // namespace rcac
