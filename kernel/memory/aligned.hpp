// Vectors that start at a cache line, so that no short vector of a tile lies across two.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace rcac {

template <class T>
struct CacheLineAllocator {
    using value_type = T;
    static constexpr std::align_val_t alignment{64};
    CacheLineAllocator() = default;
    template <class S>
    CacheLineAllocator(const CacheLineAllocator<S>&) {}
    T* allocate(std::size_t count) {
        return static_cast<T*>(::operator new(count * sizeof(T), alignment));
    }
    void deallocate(T* p, std::size_t) { ::operator delete(p, alignment); }
    friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
    friend bool operator!=(const CacheLineAllocator&, const CacheLineAllocator&) { return false; }
};

using AlignedVector = std::vector<double, CacheLineAllocator<double>>;

}  // namespace rcac
