// Pages that stand alone: one file of HTML that asks for nothing and runs only the script that it was written with.
#ifndef PHYSMAS_REPORT_PAGE_H
#define PHYSMAS_REPORT_PAGE_H

#include <string>
#include <vector>

namespace physmas::report {

// Text as it may stand in an element or in a quoted attribute: what anyone wrote is never markup. Bytes that are no
// UTF-8 and control characters are replaced.
std::string escaped(const std::string& text);

// Content of a file as an address: "data:video/mp4;base64,...".
std::string data_address(const std::string& type, const std::string& bytes);

struct Page {
  std::string title;                // text
  std::vector<std::string> styles;  // texts of lib/report/pages, one after the other
  std::string body;                 // markup
  std::vector<std::string> scripts;
};

// The document. Its content security policy allows the styles and scripts that it holds, by their hashes, pictures and
// videos that are in it, and workers of its own; no connection, no frame, no form.
std::string page_text(const Page& page);

}  // namespace physmas::report

#endif
