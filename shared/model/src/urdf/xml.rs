//! XML with places, and checked attributes.

use roxmltree::{Document, Node};

use crate::problem_error::{FindingKind, Found, Source, Span};

/// Deeper nesting is refused; a URDF needs about five levels.
const MAX_DEPTH: u32 = 64;
/// Most nodes of one document.
const MAX_NODES: u32 = 2_000_000;

/// Parses a document whose root element is `robot`.
pub(crate) fn parse<'a>(source: &'a Source, format: &str) -> Found<Document<'a>> {
    if source.path.ends_with(".xacro") {
        return Err(xacro(source, 0));
    }
    refuse_deep_nesting(source)?;
    let options = roxmltree::ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let document = Document::parse_with_options(&source.text, options).map_err(|error| {
        // The prefix is not declared in a file without its xacro header.
        if let (roxmltree::Error::UnknownNamespace(..), Some(offset)) = (&error, source.text.find("<xacro:")) {
            return xacro(source, offset);
        }
        let at = error.pos();
        source
            .finding(offset_of(&source.text, at.row, at.col), FindingKind::Malformed, format!("not XML: {error}"))
            .help(format!("give a well-formed {format} file"))
    })?;
    let macros = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|name| name.contains("xacro"));
    if let Some(node) = document.descendants().find(macros) {
        return Err(xacro(source, node.range().start));
    }
    let root = document.root_element();
    let tag = root.tag_name().name();
    if tag != "robot" {
        return Err(source
            .finding(span(source, root), FindingKind::Malformed, format!("`<{tag}>` is not a {format} file"))
            .help("the root element must be `<robot>`"));
    }
    Ok(document)
}

fn xacro(source: &Source, offset: usize) -> Box<crate::Finding> {
    let input = &source.path;
    let plain = input.trim_end_matches(".xacro").trim_end_matches(".urdf");
    source
        .finding(Span { offset, len: 0 }, FindingKind::Malformed, "xacro macros are not expanded here")
        .help(format!("expand them once and name the result: xacro {input} > {plain}.expanded.urdf"))
}

fn refuse_deep_nesting(source: &Source) -> Found<()> {
    let Some(offset) = nested_too_deep(source.text.as_bytes()) else { return Ok(()) };
    Err(source
        .finding(Span { offset, len: 1 }, FindingKind::TooLarge, format!("elements nested deeper than {MAX_DEPTH}"))
        .help("robots are described by a flat list of links and joints"))
}

/// Where elements nest deeper than any reader of XML should follow. A cheap bound, open tags minus closed ones, to be asked
/// before anything recursive sees the text.
pub(crate) fn nested_too_deep(text: &[u8]) -> Option<usize> {
    let mut depth: u32 = 0;
    text.windows(2).position(|pair| {
        match pair {
            b"</" | b"/>" => depth = depth.saturating_sub(1),
            [b'<', next] if !matches!(next, b'!' | b'?') => depth += 1,
            _ => {}
        }
        depth > MAX_DEPTH
    })
}

fn offset_of(text: &str, row: u32, col: u32) -> Span {
    let line_start = text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
    Span { offset: line_start + col.saturating_sub(1) as usize, len: 1 }
}

/// Where an element's start tag stands.
pub(crate) fn span(source: &Source, node: Node<'_, '_>) -> Span {
    let range = node.range();
    let tag = source.text.get(range.clone()).and_then(|text| text.find('>')).map_or(range.len(), |end| end + 1);
    Span { offset: range.start, len: tag }
}

/// Child elements of one tag.
pub(crate) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == tag)
}

/// The first child element of one tag.
pub(crate) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// An attribute that must be there and not be empty.
pub(crate) fn attribute<'a>(source: &Source, node: Node<'a, '_>, name: &str) -> Found<&'a str> {
    match node.attribute(name) {
        Some(value) if !value.trim().is_empty() => Ok(value.trim()),
        _ => Err(source
            .finding(
                span(source, node),
                FindingKind::BadRobot,
                format!("`<{}>` without `{name}`", node.tag_name().name()),
            )
            .help(format!("add the attribute `{name}`"))),
    }
}

/// A number in an attribute.
pub(crate) fn number(source: &Source, node: Node<'_, '_>, name: &str) -> Found<f64> {
    let text = attribute(source, node, name)?;
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(bad_number(source, node, name, text, "one finite number")),
    }
}

/// Checks every number below `node` that is read later: the readers of URDF skip what they cannot parse.
pub(crate) fn check_numbers(source: &Source, node: Node<'_, '_>) -> Found<()> {
    for element in node.descendants().filter(Node::is_element) {
        for attribute in element.attributes() {
            let count = match attribute.name() {
                "xyz" | "rpy" | "size" | "scale" => 3,
                "quat_xyzw" => 4,
                "radius" | "length" | "lower" | "upper" | "velocity" | "multiplier" | "offset" => 1,
                _ => continue,
            };
            let numbers: Vec<Option<f64>> =
                attribute.value().split_whitespace().map(|text| text.parse().ok()).collect();
            let good = |x: &Option<f64>| x.is_some_and(|x| x.abs() <= crate::file::GREATEST);
            if numbers.len() != count || !numbers.iter().all(good) {
                let wanted = format!("{count} finite number{}", if count == 1 { "" } else { "s" });
                return Err(bad_number(source, element, attribute.name(), attribute.value(), &wanted));
            }
        }
    }
    Ok(())
}

fn bad_number(source: &Source, node: Node<'_, '_>, name: &str, text: &str, wanted: &str) -> Box<crate::Finding> {
    let tag = node.tag_name().name();
    let xacro = if text.contains("${") { "; xacro expressions must be expanded first" } else { "" };
    source
        .finding(span(source, node), FindingKind::BadNumber, format!("`{name}` of `<{tag}>` is \"{text}\""))
        .help(format!("give {wanted}{xacro}"))
}
