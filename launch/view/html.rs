//! One self-contained page out of skeleton, style, data and scripts.

use contract::Digest;

/// The skeleton, with a comment where each part goes.
const SKELETON: &str = include_str!("page.html");
const STYLE: &str = include_str!("viewer.css");
/// In the order in which they need one another.
const SCRIPTS: [&str; 9] = [
    include_str!("algebra.js"),
    include_str!("shapes.js"),
    include_str!("world.js"),
    include_str!("camera.js"),
    include_str!("renderer.js"),
    include_str!("labels.js"),
    include_str!("timeline.js"),
    include_str!("panel.js"),
    include_str!("viewer.js"),
];

/// The page that shows `data` (JSON).
///
/// Its content security policy allows nothing but its own style and scripts, known by a nonce that nobody can guess
/// who writes the data, since it is the data's digest.
#[must_use]
pub fn page(title: &str, data: &str) -> String {
    let nonce = &Digest::of("mrtamp page", &[data.as_bytes()]).hex()[..32];
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data:; base-uri 'none'; \
         form-action 'none'"
    );
    let scripts = SCRIPTS.concat();
    let parts = [
        ("policy", format!("<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">")),
        ("title", format!("<title>{}</title>", text(title))),
        ("style", format!("<style nonce=\"{nonce}\">\n{STYLE}</style>")),
        ("data", format!("<script type=\"application/json\" id=\"data\" nonce=\"{nonce}\">{}</script>", inert(data))),
        ("script", format!("<script nonce=\"{nonce}\">\n\"use strict\";\n(() => {{\n{scripts}}})();\n</script>")),
    ];
    let mut page = String::with_capacity(SKELETON.len() + STYLE.len() + data.len() + scripts.len() + 1024);
    let mut rest = SKELETON;
    for (mark, part) in &parts {
        let (before, after) = rest.split_once(&format!("<!--{mark}-->")).unwrap_or((rest, ""));
        page += before;
        page += part;
        rest = after;
    }
    page + rest
}

/// Escapes text for HTML.
fn text(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// JSON that cannot end its script element: within JSON, `<` stands only in strings.
fn inert(json: &str) -> String {
    json.replace('<', "\\u003c")
}
