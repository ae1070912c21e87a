//! Pipelines are made on threads of their own while the frame that wants them is still being recorded.
//!
//! Drivers take milliseconds to make one, a frame takes dozens, and what they are made of is known one by one as passes
//! are declared: by the time that the first pass is encoded, others have made most of them.

#[cfg(not(target_arch = "wasm32"))]
pub use threads::Pipeline;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use threads::{Make, Makers};
#[cfg(target_arch = "wasm32")]
pub use web::Pipeline;
#[cfg(target_arch = "wasm32")]
pub(crate) use web::{Make, Makers};

#[cfg(not(target_arch = "wasm32"))]
mod threads {
    use std::cell::OnceCell;
    use std::fmt;
    use std::ops::Deref;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
    use std::thread::JoinHandle;
    use std::time::Instant;

    /// What makes a pipeline, on whichever thread.
    pub(crate) trait Make: Fn() -> wgpu::RenderPipeline + Send + Sync + 'static {}

    impl<M: Fn() -> wgpu::RenderPipeline + Send + Sync + 'static> Make for M {}

    /// A pipeline that is there, or is being made; whoever uses it waits for it, or makes it if nobody has begun.
    #[derive(Clone, Debug)]
    pub struct Pipeline(Arc<PendingPipeline>);

    struct PendingPipeline {
        made: OnceLock<wgpu::RenderPipeline>,
        make: Box<dyn Fn() -> wgpu::RenderPipeline + Send + Sync>,
        waited_ns: Arc<AtomicU64>,
    }

    impl PendingPipeline {
        /// A thread on which that panics leaves it to whoever uses the pipeline, who hears of it then.
        fn make(&self) -> &wgpu::RenderPipeline {
            self.made.get_or_init(|| (self.make)())
        }
    }

    impl fmt::Debug for PendingPipeline {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.made.fmt(f)
        }
    }

    impl Pipeline {
        /// One that is there.
        pub(crate) fn made(pipeline: wgpu::RenderPipeline) -> Self {
            let made = OnceLock::from(pipeline.clone());
            Self(Arc::new(PendingPipeline {
                made,
                make: Box::new(move || pipeline.clone()),
                waited_ns: Arc::default(),
            }))
        }
    }

    impl PartialEq for Pipeline {
        /// Whether they are one: nobody waits to tell.
        fn eq(&self, other: &Self) -> bool {
            Arc::ptr_eq(&self.0, &other.0)
        }
    }

    impl Deref for Pipeline {
        type Target = wgpu::RenderPipeline;

        fn deref(&self) -> &wgpu::RenderPipeline {
            self.0.made.get().unwrap_or_else(|| {
                let start = Instant::now();
                let pipeline = self.0.make();
                self.0.waited_ns.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
                pipeline
            })
        }
    }

    /// More threads than this would wait for each other in the driver.
    const THREADS_MAX: usize = 4;

    /// The threads that make pipelines, started with the first one; none where there is one processor, or the process
    /// may have no more threads: pipelines are made when they are used then.
    #[derive(Debug, Default)]
    pub(crate) struct Makers {
        started: OnceCell<PipelineWorkers>,
        waited_ns: Arc<AtomicU64>,
    }

    #[derive(Debug)]
    struct PipelineWorkers {
        wanted: Option<Sender<Weak<PendingPipeline>>>,
        threads: Vec<JoinHandle<()>>,
    }

    impl Makers {
        /// The pipeline that `make` gives, as soon as a thread comes to it.
        pub fn promise(&self, make: impl Make) -> Pipeline {
            let (make, waited_ns) = (Box::new(make), self.waited_ns.clone());
            let promised = Arc::new(PendingPipeline { made: OnceLock::new(), make, waited_ns });
            if let Some(wanted) = &self.started.get_or_init(PipelineWorkers::new).wanted {
                // Without threads nobody receives it.
                let _ = wanted.send(Arc::downgrade(&promised));
            }
            Pipeline(promised)
        }

        /// Milliseconds in which those who used pipelines waited for them.
        pub fn waited_ms(&self) -> f64 {
            self.waited_ns.load(Ordering::Relaxed) as f64 / 1e6
        }
    }

    impl PipelineWorkers {
        fn new() -> Self {
            let (wanted, receiver) = channel();
            let receiver = Arc::new(Mutex::new(receiver));
            // Who records is done long before they are, and waits.
            let processors = std::thread::available_parallelism().map_or(1, usize::from);
            let count = if processors > 1 { processors.min(THREADS_MAX) } else { 0 };
            let start = |_| {
                let receiver = receiver.clone();
                std::thread::Builder::new().name("pipelines".into()).spawn(move || make_all(&receiver)).ok()
            };
            Self { wanted: Some(wanted), threads: (0..count).filter_map(start).collect() }
        }
    }

    /// Makes what is wanted and still has an owner, until nobody can want anything more.
    fn make_all(wanted: &Mutex<Receiver<Weak<PendingPipeline>>>) {
        loop {
            let next = wanted.lock().unwrap_or_else(PoisonError::into_inner).recv();
            let Ok(promised) = next else { return };
            if let Some(promised) = promised.upgrade() {
                promised.make();
            }
        }
    }

    impl Drop for PipelineWorkers {
        /// No thread is in the driver any more when the device goes.
        fn drop(&mut self) {
            self.wanted = None;
            self.threads.drain(..).for_each(|thread| drop(thread.join()));
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod web {
    use std::ops::Deref;

    /// A pipeline; browsers make it on threads of their own.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Pipeline(wgpu::RenderPipeline);

    /// What makes a pipeline.
    pub(crate) trait Make: Fn() -> wgpu::RenderPipeline + 'static {}

    impl<M: Fn() -> wgpu::RenderPipeline + 'static> Make for M {}

    impl Pipeline {
        /// One that is there.
        pub(crate) fn made(pipeline: wgpu::RenderPipeline) -> Self {
            Self(pipeline)
        }
    }

    impl Deref for Pipeline {
        type Target = wgpu::RenderPipeline;

        fn deref(&self) -> &wgpu::RenderPipeline {
            &self.0
        }
    }

    /// Nothing: modules in browsers have one thread.
    #[derive(Debug, Default)]
    pub(crate) struct Makers;

    impl Makers {
        /// What `make` gives.
        pub fn promise(&self, make: impl Make) -> Pipeline {
            Pipeline(make())
        }

        /// None are waited for but where they are made.
        pub fn waited_ms(&self) -> f64 {
            0.0
        }
    }
}
