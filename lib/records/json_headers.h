// The common headers and JSON; precompiled for the sources that include records/json.h (see Makefile).
#ifndef PHYSMAS_RECORDS_JSON_HEADERS_H
#define PHYSMAS_RECORDS_JSON_HEADERS_H

#include <nlohmann/json.hpp>

#include "base/common_headers.h"

#endif
