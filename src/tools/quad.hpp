#pragma once
/// @file
/// Floating-point numbers of (at least) 113 bits, whatever this machine calls them.

#if !defined(__SIZEOF_FLOAT128__) && __LDBL_MANT_DIG__ < 113
#include <boost/multiprecision/cpp_bin_float.hpp>
#endif

namespace udar::tools {

#if __LDBL_MANT_DIG__ >= 113  // arm64, RISC-V, s390x
using Quad = long double;
#elif defined(__SIZEOF_FLOAT128__)  // x86, POWER
__extension__ using Quad = __float128;
#else
using Quad = boost::multiprecision::cpp_bin_float_quad;
#endif

}  // namespace udar::tools
