"""How pages look: light, dark where the reader prefers it, and on paper."""

from __future__ import annotations

STYLE = """
:root { --ink: #1d2329; --soft: #57606a; --line: #d0d7de; --band: #f3f5f7; --paper: #ffffff;
  --link: #0550ae; --given: #8a5a00; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ec; --soft: #a3adb8; --line: #3d444d; --band: #22272e; --paper: #16191d;
    --link: #79b8ff; --given: #e3b341; }
  .figure img { background: #ffffff; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, "Segoe UI", "Liberation Sans", Arial, sans-serif; }
main { max-width: 66rem; margin: 0 auto; padding: 1.5rem 1.25rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0.5rem 0 0.25rem; }
h2 { font-size: 1.35rem; margin: 2.5rem 0 0.5rem; padding-top: 0.75rem;
  border-top: 1px solid var(--line); }
h3 { font-size: 1.08rem; margin: 1.75rem 0 0.4rem; }
p { margin: 0.5rem 0; max-width: 48rem; }
a { color: var(--link); }
ul { padding-left: 1.25rem; }
.lead { font-size: 1.08rem; }
.soft, .caption { color: var(--soft); font-size: 0.92rem; }
.note { border-left: 4px solid var(--given); padding-left: 0.75rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.75rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: 0.28rem 0.7rem; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
thead th { border-bottom: 2px solid var(--soft); vertical-align: bottom; }
.right { text-align: right; white-space: nowrap; }
.given td, .given th { color: var(--given); }
.first td, .first th { border-top: 2px solid var(--line); }
.soft-cell { color: var(--soft); }
.figure { margin: 1rem 0 1.5rem; }
.figure img { max-width: 100%; height: auto; display: block; }
details { margin: 0.75rem 0; }
summary { cursor: pointer; color: var(--link); }
code, pre { font: 0.92em/1.45 ui-monospace, "DejaVu Sans Mono", Consolas, monospace; }
pre { background: var(--band); padding: 0.75rem; overflow-x: auto; white-space: pre-wrap; }
@media print {
  :root { --ink: #000000; --soft: #444444; --line: #bbbbbb; --band: #f3f5f7; --paper: #ffffff;
    --link: #000000; --given: #6b4600; }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  h2, h3 { break-after: avoid; }
  .figure, tr { break-inside: avoid; }
  details::details-content { content-visibility: visible; display: block; }
}
"""

PRINT_STYLE = """
body { font-family: "Liberation Sans", "DejaVu Sans", Arial, sans-serif; font-size: 9pt;
  color: #000000; }
h1 { font-size: 17pt; }
h2 { font-size: 13pt; margin-top: 16px; }
h3 { font-size: 10.5pt; margin-top: 12px; }
p { margin-top: 4px; margin-bottom: 4px; }
p.lead { font-size: 10pt; }
p.soft, p.caption { color: #444444; font-size: 8pt; }
th, td { padding: 2px 6px; font-size: 8pt; border-bottom-width: 1px;
  border-bottom-style: solid; border-bottom-color: #d0d7de; }
h2.new-page { page-break-before: always; }
td.right, th.right { text-align: right; }
th { font-weight: bold; text-align: left; }
tr.given td, tr.given th { color: #6b4600; }
pre { font-family: "DejaVu Sans Mono", monospace; font-size: 8pt; }
"""
