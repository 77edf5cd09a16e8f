//! Networks of kind `gc` are written here, operator by operator; those beyond the limits are never run.

use super::*;
use crate::net::{LoadOptions, Model, Runtime, RuntimeOptions, inspect_bytes};
use crate::run::{Key, Stream};

/// A message of protocol buffers.
#[derive(Debug, Clone, Default)]
struct Message(Vec<u8>);

impl Message {
    fn varint(mut self, mut value: u64) -> Message {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
        self
    }

    fn number(self, field: u64, value: i64) -> Message {
        self.varint(field << 3).varint(value as u64)
    }

    fn bytes(self, field: u64, bytes: &[u8]) -> Message {
        let mut out = self.varint(field << 3 | 2).varint(bytes.len() as u64);
        out.0.extend(bytes);
        out
    }

    fn text(self, field: u64, text: &str) -> Message {
        self.bytes(field, text.as_bytes())
    }

    fn of(self, field: u64, message: &Message) -> Message {
        self.bytes(field, &message.0)
    }
}

/// An attribute's value.
enum Given<'a> {
    Int(i64),
    Ints(&'a [i64]),
    Text(&'a str),
    Graph,
}

fn attribute(name: &str, value: &Given) -> Message {
    let message = Message::default().text(1, name);
    match value {
        Given::Int(n) => message.number(3, *n).number(20, 2),
        Given::Ints(list) => list.iter().fold(message, |m, n| m.number(8, *n)).number(20, 7),
        Given::Text(text) => message.text(4, text).number(20, 3),
        Given::Graph => message.of(6, &Message::default().text(2, "body")).number(20, 5),
    }
}

/// A network as it is written down.
#[derive(Debug, Clone, Default)]
struct Net {
    graph: Message,
    more: Message,
    names: usize,
}

impl Net {
    fn node(&mut self, operator: &str, inputs: &[&str], outputs: &[&str], attributes: &[(&str, Given)]) {
        let node = inputs.iter().fold(Message::default(), |m, name| m.text(1, name));
        let node = outputs.iter().fold(node, |m, name| m.text(2, name)).text(4, operator);
        let node = attributes.iter().fold(node, |m, (name, value)| m.of(5, &attribute(name, value)));
        self.graph = std::mem::take(&mut self.graph).of(1, &node);
    }

    /// An operator with one result of a new name.
    fn make(&mut self, operator: &str, inputs: &[&str], attributes: &[(&str, Given)]) -> String {
        self.names += 1;
        let name = format!("v{}", self.names);
        self.node(operator, inputs, &[&name], attributes);
        name
    }

    fn weight(&mut self, dims: &[i64], dtype: i64, raw: &[u8]) -> String {
        self.names += 1;
        let name = format!("w{}", self.names);
        let tensor = dims.iter().fold(Message::default(), |m, n| m.number(1, *n));
        let tensor = tensor.number(2, dtype).text(8, &name).bytes(9, raw);
        self.graph = std::mem::take(&mut self.graph).of(5, &tensor);
        name
    }

    fn ints(&mut self, values: &[i64]) -> String {
        let raw: Vec<u8> = values.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.weight(&[values.len() as i64], 7, &raw)
    }

    fn floats(&mut self, dims: &[i64], value: f32) -> String {
        let count = dims.iter().product::<i64>() as usize;
        let raw: Vec<u8> = std::iter::repeat_n(value, count).flat_map(f32::to_le_bytes).collect();
        self.weight(dims, 1, &raw)
    }

    /// The answer: one number made of a tensor's dimensions, those of higher places `BASE` times as much.
    fn answer(&mut self, from: &str, rank: usize) {
        let raw: Vec<u8> = (0..rank as u32).flat_map(|k| (BASE.pow(k) as f32).to_le_bytes()).collect();
        let places = self.weight(&[rank as i64], 1, &raw);
        let sizes = self.make("Shape", &[from], &[]);
        let sizes = self.make("Cast", &[&sizes], &[("to", Given::Int(1))]);
        let sum = self.make("Mul", &[&sizes, &places], &[]);
        let sum = self.make("ReduceSum", &[&sum], &[("keepdims", Given::Int(0))]);
        let one = self.ints(&[1]);
        self.node("Reshape", &[&sum, &one], &["probability"], &[]);
    }

    fn file(&self) -> Vec<u8> {
        let dim = |value: u64| match value {
            0 => Message::default().text(2, "batch"),
            n => Message::default().number(1, n as i64),
        };
        let value = |name: &str, dims: &[u64]| {
            let shape = dims.iter().fold(Message::default(), |m, n| m.of(1, &dim(*n)));
            let tensor = Message::default().number(1, 1).of(2, &shape);
            Message::default().text(1, name).of(2, &Message::default().of(1, &tensor))
        };
        let graph = self.graph.clone().text(2, "g");
        let graph = graph.of(11, &value("image", &[0, 2, 32, 32])).of(12, &value("probability", &[0]));
        let mut model = Message::default().number(1, 10).of(7, &graph);
        model = model.of(8, &Message::default().text(1, "").number(2, 18));
        let spec = r#"{"pixel":0.002,"size":32}"#;
        for (key, text) in [("kind", "gc"), ("interface", "1"), ("gripper", "g"), ("spec", spec)] {
            model = model.of(14, &Message::default().text(1, key).text(2, text));
        }
        model.0.extend(&self.more.0);
        model.0
    }
}

const BASE: u32 = 61;

fn fault(file: &[u8]) -> Option<(ModelFault, String)> {
    match inspect_bytes(Path::new("x.onnx"), file, None, &LoadOptions::default()) {
        Ok(_) => None,
        Err(Error::Model { fault, expected, found, .. }) => Some((fault, format!("{expected}; {found}"))),
        Err(other) => panic!("{other}"),
    }
}

/// A network whose answer is made of the image by these operators and no others.
fn plain(edit: impl FnOnce(&mut Net, &str) -> String, rank: usize) -> Net {
    let mut net = Net::default();
    let image = net.make("Relu", &["image"], &[]);
    let made = edit(&mut net, &image);
    net.answer(&made, rank);
    net
}

#[test]
fn what_controls_the_flow_or_may_have_any_size_is_refused_before_a_runtime_sees_it() {
    assert_eq!(fault(&plain(|_, image| image.into(), 4).file()), None);
    let mut cases: Vec<(Net, &str)> = Vec::new();
    for operator in ["Loop", "If", "Scan", "SequenceMap"] {
        // Harmless bodies: empty, and with a graph of no operators.
        cases.push((plain(|net, image| net.make(operator, &[image], &[]), 4), operator));
        cases.push((plain(|net, image| net.make(operator, &[image], &[("body", Given::Graph)]), 4), operator));
    }
    for operator in ["NonZero", "NonMaxSuppression", "Unique", "Compress", "RandomNormal", "Whatever", ""] {
        cases.push((plain(|net, image| net.make(operator, &[image], &[]), 4), operator));
    }
    cases.push((plain(|net, image| net.make("Relu", &[image], &[("hidden", Given::Graph)]), 4), "controls the flow"));
    let mut functions = plain(|_, image| image.into(), 4);
    functions.more = Message::default().of(25, &Message::default().text(1, "f"));
    cases.push((functions, "functions"));
    let mut sparse = plain(|_, image| image.into(), 4);
    sparse.graph = sparse.graph.of(15, &Message::default());
    cases.push((sparse, "sparse"));
    let foreign = Message::default().text(1, "image").text(2, "x").text(4, "Relu").text(7, "com.microsoft");
    let mut domain = plain(|_, image| image.into(), 4);
    domain.graph = domain.graph.of(1, &foreign);
    cases.push((domain, "`com.microsoft.Relu`"));
    for (net, says) in cases {
        let (found, text) = fault(&net.file()).expect(says);
        assert_eq!(found, ModelFault::Operator, "{text}");
        assert!(text.contains(says), "{says}: {text}");
        // No runtime was asked for: this one is not there.
        let nowhere = RuntimeOptions { library: Some("/nowhere/libonnxruntime.so".into()), backend: None };
        let options = LoadOptions { runtime: nowhere, ..LoadOptions::default() };
        let error = Model::from_bytes("x.onnx", net.file(), None, &options).map(drop).unwrap_err();
        assert!(matches!(error, Error::Model { fault: ModelFault::Operator, .. }), "{error}");
    }
}

#[test]
fn weights_in_another_file_or_of_more_values_than_there_are_bytes_are_refused() {
    for place in [Message::default().number(14, 1), Message::default().of(13, &Message::default().text(1, "location"))]
    {
        let mut net = plain(|_, image| image.into(), 4);
        let tensor = Message::default().number(1, 4).number(2, 1).text(8, "far");
        net.graph = net.graph.of(5, &Message([tensor.0, place.0].concat()));
        let (found, text) = fault(&net.file()).unwrap();
        assert_eq!(found, ModelFault::External, "{text}");
        assert!(text.contains("`far` in another file"), "{text}");
    }
    for dims in [vec![1 << 40], vec![1 << 20, 1 << 20, 1 << 30], vec![i64::MAX, i64::MAX], vec![1000]] {
        let mut net = plain(|_, image| image.into(), 4);
        net.weight(&dims, 1, &[0; 64]);
        assert_eq!(fault(&net.file()).unwrap().0, ModelFault::Size, "{dims:?}");
    }
}

/// Every operator that makes more than it gets, on both sides of the limit.
#[test]
fn what_becomes_too_big_is_refused_and_what_does_not_is_taken() {
    type Make = fn(&mut Net, &str, i64) -> String;
    // Each makes about `n` values of one or a few.
    let growing: [(&str, usize, Make); 8] = [
        ("Expand", 1, |net, _, n| {
            let (one, size) = (net.floats(&[1], 0.0), net.ints(&[n]));
            net.make("Expand", &[&one, &size], &[])
        }),
        ("Tile", 1, |net, _, n| {
            let (one, size) = (net.floats(&[1], 0.0), net.ints(&[n]));
            net.make("Tile", &[&one, &size], &[])
        }),
        ("ConstantOfShape", 2, |net, _, n| {
            let size = net.ints(&[2, n / 2]);
            net.make("ConstantOfShape", &[&size], &[])
        }),
        ("Range", 1, |net, _, n| {
            let [from, to, by] = [0, n, 1].map(|v: i64| net.weight(&[], 7, &v.to_le_bytes()));
            net.make("Range", &[&from, &to, &by], &[])
        }),
        ("Pad", 1, |net, _, n| {
            let (one, pads) = (net.floats(&[1], 0.0), net.ints(&[n / 2, n / 2 - 1]));
            net.make("Pad", &[&one, &pads], &[])
        }),
        ("OneHot", 2, |net, _, n| {
            let (one, depth, pair) = (net.ints(&[0]), net.weight(&[], 7, &n.to_le_bytes()), net.floats(&[2], 0.0));
            net.make("OneHot", &[&one, &depth, &pair], &[])
        }),
        ("Resize", 4, |net, image, n| {
            let size = net.ints(&[1, 2, 32, n / 64]);
            net.make("Resize", &[image, "", "", &size], &[])
        }),
        ("Add", 2, |net, _, n| {
            let side = (n as f64).sqrt() as i64;
            let column = net.floats(&[side, 1], 0.0);
            let row = net.floats(&[1, side], 0.0);
            net.make("Add", &[&column, &row], &[])
        }),
    ];
    for (name, rank, make) in growing {
        for factor in [0.001, 0.1, 0.9, 1.1, 8.0] {
            let n = (MOST_VALUES as f64 * factor) as i64;
            let found = fault(&plain(|net, image| make(net, image, n), rank).file());
            match found {
                None => assert!(factor < 1.0, "{name} of {n}"),
                Some((fault, text)) => {
                    assert!(factor > 1.0 && fault == ModelFault::Size, "{name} of {n}: {text}");
                    assert!(text.contains(name), "{text}");
                }
            }
        }
    }
    // A size that depends on values is not told.
    let data = plain(
        |net, image| {
            let size = net.make("Cast", &[image], &[("to", Given::Int(7))]);
            let one = net.ints(&[-1]);
            let size = net.make("Reshape", &[&size, &one], &[]);
            net.make("ConstantOfShape", &[&size], &[])
        },
        1,
    );
    assert!(fault(&data.file()).unwrap().1.contains("depends on values"));
}

#[test]
fn many_tensors_at_once_and_much_work_are_refused() {
    // As many as fit in a chain pass, for each goes before the next comes; side by side they do not.
    let part = (MOST_VALUES / 2) as i64;
    let many = 3 * (MOST_AT_ONCE / MOST_VALUES) as usize;
    let chain = |parallel: bool| {
        plain(
            |net, image| {
                let size = net.ints(&[part]);
                let first = net.make("ReduceSum", &[image], &[("keepdims", Given::Int(0))]);
                let parts: Vec<String> = (0..many).map(|_| net.make("Expand", &[&first, &size], &[])).collect();
                if !parallel {
                    return net.make("ReduceSum", &[&parts[0]], &[("keepdims", Given::Int(1))]);
                }
                let names: Vec<&str> = parts.iter().map(String::as_str).collect();
                net.make("Sum", &names, &[])
            },
            1,
        )
    };
    assert_eq!(fault(&chain(false).file()), None);
    assert!(fault(&chain(true).file()).unwrap().1.contains("at the same time"));
    for (times, fits) in [(1, true), (8, true), (40, false)] {
        let square = plain(
            |net, image| {
                let first = net.make("ReduceSum", &[image], &[("keepdims", Given::Int(0))]);
                let size = net.ints(&[1 << 13, 1 << 10]);
                let a = net.make("Expand", &[&first, &size], &[]);
                let turned = net.make("Transpose", &[&a], &[]);
                let mut product = net.make("MatMul", &[&a, &turned], &[]);
                for _ in 0..times {
                    product = net.make("MatMul", &[&product, &a], &[]);
                    product = net.make("MatMul", &[&product, &turned], &[]);
                }
                product
            },
            2,
        );
        let found = fault(&square.file());
        assert_eq!(found.is_none(), fits, "{times}: {found:?}");
        assert!(found.is_none_or(|(_, text)| text.contains("multiplications")));
    }
}

/// An operator on `from` of these dimensions, drawn; the sizes decide what can follow.
fn drawn(net: &mut Net, from: &str, dims: &[u64], draw: &mut Stream) -> String {
    let before = net.graph.0.len();
    let rank = dims.len();
    let mut pick = |n: usize| draw.index(n);
    let at = pick(rank.max(1));
    let (low, high) = (pick(5) as i64 - 2, pick(9) as i64 - 2);
    let picture = rank == 4;
    match pick(22) {
        0 => net.make("Transpose", &[from], &[]),
        1 => {
            let axes = net.ints(&[at as i64]);
            net.make("ReduceMax", &[from, &axes], &[("keepdims", Given::Int(low & 1))])
        }
        2 => {
            let axes = net.ints(&[at as i64]);
            net.make("Unsqueeze", &[from, &axes], &[])
        }
        3 => net.make("Squeeze", &[from], &[]),
        4 => {
            let shape = net.ints(&[0, -1]);
            net.make("Reshape", &[from, &shape], &[])
        }
        5 => {
            let shape = net.ints(&[2, -1, 2]);
            net.make("Reshape", &[from, &shape], &[])
        }
        6 | 7 => {
            let step = [1, 2, -1, -3][pick(4)];
            let far = [high, i64::MAX, i64::MIN + 1, -1][pick(4)];
            let [starts, ends, axes, steps] = [low, far, at as i64, step].map(|v| net.ints(&[v]));
            net.make("Slice", &[from, &starts, &ends, &axes, &steps], &[])
        }
        8 => {
            let pads: Vec<i64> = (0..2 * rank).map(|k| if k % rank.max(1) == at { 1 } else { 0 }).collect();
            let pads = net.ints(&pads);
            net.make("Pad", &[from, &pads], &[])
        }
        9 => net.make("Concat", &[from, from], &[("axis", Given::Int(at as i64))]),
        10 => {
            let places = net.ints(&[0, 0, 0]);
            net.make("Gather", &[from, &places], &[("axis", Given::Int(at as i64))])
        }
        11 => {
            let repeats: Vec<i64> = (0..rank).map(|k| if k == at { 2 } else { 1 }).collect();
            let repeats = net.ints(&repeats);
            net.make("Tile", &[from, &repeats], &[])
        }
        12 => net.make("Flatten", &[from], &[("axis", Given::Int(at as i64))]),
        13 => net.make("Softmax", &[from], &[]),
        14 => {
            let turned = net.make("Transpose", &[from], &[]);
            net.make("MatMul", &[from, &turned], &[])
        }
        15 => {
            let sizes = net.make("Shape", &[from], &[]);
            let two = net.ints(&[2]);
            let more = net.make("Concat", &[&two, &sizes], &[("axis", Given::Int(0))]);
            net.make("Expand", &[from, &more], &[])
        }
        16 if picture => {
            let weight = net.floats(&[3, dims[1] as i64, 3, 2], 0.0);
            let [strides, dilations] = [[2, 1], [1, 2]];
            let more = [
                ("strides", Given::Ints(&strides)),
                ("dilations", Given::Ints(&dilations)),
                ("pads", Given::Ints(&[1, 0, 2, 1])),
            ];
            net.make("Conv", &[from, &weight], &more)
        }
        17 if picture => {
            let weight = net.floats(&[dims[1] as i64, 2, 3, 2], 0.0);
            let more = [
                ("strides", Given::Ints(&[2, 1])),
                ("output_padding", Given::Ints(&[1, 0])),
                ("pads", Given::Ints(&[1, 0, 0, 1])),
            ];
            net.make("ConvTranspose", &[from, &weight], &more)
        }
        18 if picture => {
            let kernel = [3, 2];
            let same = [
                ("kernel_shape", Given::Ints(&kernel)),
                ("strides", Given::Ints(&[2, 2])),
                ("auto_pad", Given::Text("SAME_UPPER")),
            ];
            let ceil = [
                ("kernel_shape", Given::Ints(&kernel)),
                ("strides", Given::Ints(&[2, 2])),
                ("ceil_mode", Given::Int(low & 1)),
            ];
            net.make("MaxPool", &[from], if high & 1 == 0 { &same } else { &ceil })
        }
        19 if picture => net.make("GlobalAveragePool", &[from], &[]),
        20 => {
            let most = net.ints(&[1]);
            let (values, places) = (format!("t{before}"), format!("i{before}"));
            net.node("TopK", &[from, &most], &[&values, &places], &[("axis", Given::Int(at as i64))]);
            values
        }
        _ => {
            let index = net.make("ArgMax", &[from], &[("axis", Given::Int(at as i64))]);
            net.make("Cast", &[&index], &[("to", Given::Int(1))])
        }
    }
}

/// The dimensions that are told of a tensor; none where the network is refused.
fn told(net: &Net, name: &str) -> Option<Vec<u64>> {
    // Its name is an output's, so that nothing releases it.
    let graph = Graph::read(&Message::default().number(1, 10).of(7, &net.graph).0).unwrap();
    let mut walk = Walk { known: HashMap::new(), at_once: 0, work: 0 };
    walk.keep("image", Shaped::of(vec![1, 2, 32, 32])).unwrap();
    for (name, tensor) in &graph.weights {
        walk.known.insert(name, Shaped::constant(tensor));
    }
    graph.nodes.iter().try_for_each(|node| walk.step(node)).ok()?;
    walk.known.get(name).map(|shaped| shaped.dims.clone())
}

/// PyTorch's export of an attention takes the sizes of its heads by remainders of constants.
#[test]
fn sizes_by_a_remainder_are_told_as_the_standard_has_them() {
    for (a, b, fmod, want) in [
        (7, 3, 0, Some(1)),
        (6, 3, 0, Some(0)),
        (-7, 3, 0, Some(2)),
        (7, 3, 1, Some(1)),
        (7, -3, 1, Some(1)),
        // Below zero, and undefined.
        (7, -3, 0, None),
        (-7, 3, 1, None),
        (7, 0, 0, None),
    ] {
        let mut net = Net::default();
        let [x, y] = [a, b].map(|v| net.ints(&[v]));
        let rest = net.make("Mod", &[&x, &y], &[("fmod", Given::Int(fmod))]);
        let filled = net.make("ConstantOfShape", &[&rest], &[]);
        assert_eq!(told(&net, &filled), want.map(|n| vec![n]), "{a} mod {b}, fmod {fmod}");
    }
    let mut net = Net::default();
    let sizes = net.make("Shape", &["image"], &[]);
    let [two, three, zero] = [2, 3, 0].map(|v| net.ints(&[v]));
    let rest = net.make("Mod", &[&two, &three], &[]);
    let head = net.make("Slice", &[&sizes, &zero, &rest], &[]);
    let filled = net.make("ConstantOfShape", &[&head], &[]);
    assert_eq!(told(&net, &filled), Some(vec![1, 2]));
}

/// The sizes that are told are those that the runtime makes, in networks of operators drawn at random.
#[test]
fn sizes_are_told_as_a_runtime_makes_them() {
    if let Err(error) = Runtime::open(&RuntimeOptions::default()) {
        println!("skipped: {error}");
        return;
    }
    let mut seen = std::collections::BTreeSet::new();
    let mut checked = 0;
    for seed in 0..150 {
        let mut draw = Key::new(seed).stream();
        let mut net = Net::default();
        let (mut name, mut dims) = ("image".to_string(), vec![1, 2, 32, 32]);
        for _ in 0..4 {
            let mut next = net.clone();
            let made = drawn(&mut next, &name, &dims, &mut draw);
            let Some(sizes) = told(&next, &made) else { continue };
            let fits = sizes.len() <= 4 && sizes.iter().all(|n| (1..u64::from(BASE)).contains(n));
            if fits && !sizes.is_empty() && sizes.iter().product::<u64>() < 20_000 {
                (net, name, dims) = (next, made, sizes);
            }
        }
        let graph = Graph::read(&Message::default().number(1, 10).of(7, &net.graph).0).unwrap();
        seen.extend(graph.nodes.iter().map(|node| node.operator.clone()));
        net.answer(&name, dims.len());
        let options = LoadOptions { self_test: false, ..LoadOptions::default() };
        let model = Model::from_bytes("x.onnx", net.file(), None, &options).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let image = vec![0.5; 2 * 32 * 32];
        let mut outputs = vec![Vec::new()];
        model.run(1, 1, &[&image], &mut outputs).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let wanted: u64 = dims.iter().enumerate().map(|(k, n)| n * u64::from(BASE.pow(k as u32))).sum();
        assert_eq!(outputs[0], [wanted as f32], "{seed}: {dims:?} by {:?}", graph.nodes);
        checked += 1;
    }
    assert!(checked > 100 && seen.len() > 18, "{checked} networks of {seen:?}");
}
