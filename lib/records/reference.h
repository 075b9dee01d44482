// From a noun phrase to an object or a row of the inventory.
#ifndef PHYSMAS_RECORDS_REFERENCE_H
#define PHYSMAS_RECORDS_REFERENCE_H

#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas {

// The words of a noun phrase without determiners: {"strawberry", "cake"}. For "the head of the hammer" the head noun
// comes last: {"hammer", "head"}. A pronoun stays: {"it"}.
using NounPhrase = std::vector<std::string>;

// The object ids and row keys that `phrase` fits best. A name fits when its head noun, or that of its id, is the
// phrase's in the singular; among those the one with the most words in the phrase wins (the words of a
// row's object count for the row), an object before its rows. More than one: the phrase is ambiguous. Residual rows
// cannot be meant.
std::vector<std::string> find_references(const Inventory& inventory, const NounPhrase& phrase);

// The rows that share a word of their names with the head noun, when no name has it as its own head and all of them are
// parts of one object: "the flower" of a sunflower with flower petals and a flower disc. Else empty.
std::vector<std::string> find_group(const Inventory& inventory, const NounPhrase& phrase);

// Every object id and semantic row key, for messages.
std::vector<std::string> all_references(const Inventory& inventory);

// The object id of a reference (an object id or a row key).
std::string object_of(const std::string& reference);

}  // namespace physmas

#endif
